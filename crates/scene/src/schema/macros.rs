//! The macros.

/// Declares settings: a struct with its defaults, its reader and the list of its keys.
///
/// A field is declared as `name: Type = default`, behind the sentence that says what the key does. What follows is
/// optional, and in this order:
///
/// | | |
/// |---|---|
/// | `in` | which values are allowed ([`Value::Allowed`](super::Value::Allowed)) |
/// | `unit` | the unit of its numbers |
/// | `without` | what holds if the key is left out, of a key without a default |
/// | `start` | where a control begins that is switched on |
/// | `slider` | the part of the range that a control goes through |
/// | `rival` | the key in whose place it stands |
/// | `only` | the methods that use it, of those that share the struct |
/// | `refines` | larger numbers make the image better and slower |
/// | `tried` | the values that comparisons try |
///
/// A field of another settings struct brings its keys into the same table. `check` names a function that looks for
/// contradictions once everything is read.
macro_rules! settings {
    (
        $(#[$meta:meta])*
        pub struct $Name:ident {
            $(
                $(#[doc = $about:literal])+
                $field:ident: $Type:ty = $default:expr
                $(, in $allowed:expr)?
                $(, unit $unit:literal)?
                $(, without $without:literal)?
                $(, start $start:literal)?
                $(, slider $slider:expr)?
                $(, rival $rival:literal)?
                $(, only $only:expr)?
                $(, refines $refines:literal)?
                $(, tried $tried:expr)?
                ;
            )*
        }
        $(check $check:path;)?
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, PartialEq)]
        pub struct $Name {
            $(
                $(#[doc = $about])+
                #[doc = concat!(
                    "\n\nDefault: `", stringify!($default), "`",
                    $("; allowed: `", stringify!($allowed), "`",)?
                    $("; unit: ", $unit,)?
                    "."
                )]
                pub $field: $Type,
            )*
        }

        impl Default for $Name {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }

        impl $Name {
            /// Returns its keys with the values in force, in the order of their declaration.
            pub fn keys(&self) -> Vec<$crate::schema::Key> {
                $crate::schema::Settings::keys(self)
            }
        }

        impl $crate::schema::Settings for $Name {
            fn keys(&self) -> Vec<$crate::schema::Key> {
                use $crate::schema::{Key, SettingsField, allowed};
                [$(SettingsField::keys(
                    &self.$field,
                    Key {
                        $(unit: $unit,)?
                        $(without: $without,)?
                        $(start: $start,)?
                        $(slider: $slider,)?
                        $(rival: Some($rival),)?
                        $(only: $only,)?
                        $(refines: $refines,)?
                        $(tried: Some($tried),)?
                        ..Key::new(stringify!($field), concat!($($about),+))
                    },
                    allowed!($($allowed)?),
                ),)*]
                .into_iter()
                .flatten()
                .collect()
            }

            fn parts<'a>(&'a self, all: &mut Vec<&'a dyn std::any::Any>) {
                all.push(self);
                $($crate::schema::SettingsField::parts(&self.$field, all);)*
            }

            fn read(&mut self, table: &$crate::table::Table<'_>) -> Result<(), $crate::error::Error> {
                use $crate::schema::{SettingsField, allowed};
                $(SettingsField::update(&mut self.$field, table, stringify!($field), allowed!($($allowed)?))?;)*
                $($check(self, table)?;)?
                Ok(())
            }
        }

        impl $crate::schema::SettingsField for $Name {
            type Allowed = ();

            fn keys(&self, _: $crate::schema::Key, (): ()) -> Vec<$crate::schema::Key> {
                $crate::schema::Settings::keys(self)
            }

            fn parts<'a>(&'a self, all: &mut Vec<&'a dyn std::any::Any>) {
                $crate::schema::Settings::parts(self, all);
            }

            fn update(
                &mut self,
                table: &$crate::table::Table<'_>,
                _: &str,
                (): (),
            ) -> Result<(), $crate::error::Error> {
                $crate::schema::Settings::read(self, table)
            }
        }
    };
}

/// The declared range; `()` without one.
macro_rules! allowed {
    () => {
        ()
    };
    ($allowed:expr) => {
        $allowed
    };
}

/// Declares an enum that a file spells as words. The first one is the default.
macro_rules! words {
    (
        $(#[$meta:meta])*
        pub enum $Name:ident {
            $($(#[doc = $about:literal])+ $Variant:ident = $word:literal,)+
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        pub enum $Name {
            $(
                $(#[doc = $about])+
                #[doc = concat!("\n\nA scene file writes `\"", $word, "\"`.")]
                $Variant,
            )+
        }

        impl $Name {
            const WORDS: &'static [$crate::schema::Word] =
                &[$($crate::schema::Word { name: $word, about: concat!($($about),+).trim_ascii_start() }),+];
            const ALL: &'static [(&'static str, Self)] = &[$(($word, Self::$Variant)),+];

            /// Returns the word that a scene file has for it.
            pub fn word(self) -> &'static str {
                match self {
                    $(Self::$Variant => $word,)+
                }
            }
        }

        impl Default for $Name {
            fn default() -> Self {
                Self::ALL[0].1
            }
        }

        $crate::schema::value! {
            $Name => $crate::schema::ValueKind::Words($Name::WORDS);
            |table, key| table.choice(key, $Name::ALL);
            |word| Some($crate::setting::Setting::Word(word.word().to_owned()));
        }
    };
}

/// Makes a type the value of a key ([`Value`](super::Value)): its form in a file, how it is read, and what a file has
/// for it. `in Type as name` gives both of the former what is allowed.
macro_rules! value {
    ($Type:ty => $kind:expr; $($rest:tt)+) => {
        $crate::schema::value! { $Type, in () as () => $kind; $($rest)+ }
    };
    (
        $Type:ty, in $Allowed:ty as $allowed:pat => $kind:expr;
        |$table:ident, $key:ident| $read:expr;
        |$value:pat_param| $setting:expr;
    ) => {
        impl $crate::schema::Value for $Type {
            type Allowed = $Allowed;

            fn kind($allowed: $Allowed) -> $crate::schema::ValueKind {
                $kind
            }

            fn read(
                $table: &$crate::table::Table<'_>,
                $key: &str,
                $allowed: $Allowed,
            ) -> Result<Option<Self>, $crate::error::Error> {
                $read
            }

            fn setting(&self) -> Option<$crate::setting::Setting> {
                let $value = self;
                $setting
            }
        }
    };
}

/// Lists keys that no field declares: names, behind the sentences that say what they do, and what is declared of fields
/// as well.
macro_rules! keys {
    ($(
        $(#[doc = $about:literal])+
        $name:literal: $kind:expr
        $(, unit $unit:literal)?
        $(, value $value:expr)?
        $(, without $without:literal)?
        $(, rival $rival:literal)?
        ;
    )+) => {
        vec![$($crate::schema::Key {
            kind: $kind,
            $(unit: $unit,)?
            $(value: $value,)?
            $(without: $without,)?
            $(rival: Some($rival),)?
            ..$crate::schema::Key::new($name, concat!($($about),+))
        }),+]
    };
}

pub(crate) use {allowed, keys, settings, value, words};
