//! Lists of all values by which variants of shaders differ.

/// A property by which variants of shaders differ, with a list of all its values.
/// [`choices!`](macro@crate::choices) makes it and forgets none.
pub trait Choices: Sized {
    /// Every value once.
    fn all() -> Vec<Self>;
}

impl Choices for bool {
    fn all() -> Vec<Self> {
        vec![false, true]
    }
}

impl<A: Choices + Clone, B: Choices> Choices for (A, B) {
    fn all() -> Vec<Self> {
        A::all().into_iter().flat_map(|a| B::all().into_iter().map(move |b| (a.clone(), b))).collect()
    }
}

/// Lists all values of an enum, or of a struct whose members are [`Choices`](crate::choices::Choices) themselves.
/// A value or member that is left out does not compile.
///
/// ```
/// use pellucid_engine::choices;
/// use pellucid_engine::choices::Choices;
///
/// #[derive(Debug, Clone, Copy, PartialEq)]
/// enum Shape {
///     Disc,
///     Square,
/// }
/// choices!(enum Shape { Disc, Square });
///
/// #[derive(Debug, PartialEq)]
/// struct Kind {
///     shape: Shape,
///     counted: bool,
/// }
/// choices!(struct Kind { shape, counted });
///
/// assert_eq!(Kind::all().len(), 4);
/// assert_eq!(Kind::all()[3], Kind { shape: Shape::Square, counted: true });
/// ```
/// ```compile_fail,E0004
/// # enum Shape { Disc, Square }
/// pellucid_engine::choices!(enum Shape { Disc });
/// ```
/// ```compile_fail,E0063
/// # struct Kind { planes: bool, counted: bool }
/// pellucid_engine::choices!(struct Kind { planes });
/// ```
#[macro_export]
macro_rules! choices {
    (enum $name:ident { $($value:ident),* $(,)? }) => {
        impl $crate::choices::Choices for $name {
            fn all() -> Vec<Self> {
                // Refused by the compiler if a value is missing.
                fn _exhaustive(value: &$name) {
                    match value {
                        $($name::$value => {})*
                    }
                }
                vec![$($name::$value),*]
            }
        }
    };
    (struct $name:ident { $($member:ident),* $(,)? }) => {
        impl $crate::choices::Choices for $name {
            fn all() -> Vec<Self> {
                let mut all = Vec::new();
                $crate::choices!(@each all, $name, [], $($member,)*);
                all
            }
        }
    };
    (@each $all:ident, $name:ident, [$($done:ident)*],) => { $all.push($name { $($done),* }) };
    (@each $all:ident, $name:ident, [$($done:ident)*], $member:ident, $($rest:ident,)*) => {
        for $member in $crate::choices::Choices::all() {
            $crate::choices!(@each $all, $name, [$($done)* $member], $($rest,)*);
        }
    };
}
