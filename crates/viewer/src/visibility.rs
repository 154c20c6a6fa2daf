//! Whether a window is on the screen at all: what is minimized need not be drawn.

use winit::window::Window;

/// A window whose state can be asked for.
pub struct Visibility {
    #[cfg(all(unix, not(target_vendor = "apple")))]
    server: Option<x11::Server>,
}

impl Visibility {
    pub fn of(window: &Window) -> Self {
        #[cfg(not(all(unix, not(target_vendor = "apple"))))]
        let _ = window;
        Self {
            #[cfg(all(unix, not(target_vendor = "apple")))]
            server: x11::Server::of(window),
        }
    }

    /// Whether the window is minimized, as far as the system tells: Wayland doesn't.
    pub fn is_minimized(&self, window: &Window) -> bool {
        #[cfg(all(unix, not(target_vendor = "apple")))]
        if self.server.as_ref().and_then(x11::Server::is_mapped) == Some(false) {
            return true;
        }
        window.is_minimized() == Some(true)
    }
}

#[cfg(all(unix, not(target_vendor = "apple")))]
mod x11 {
    use raw_window_handle::{HasWindowHandle, RawWindowHandle};
    use winit::window::Window;
    use x11rb::protocol::xproto::{ConnectionExt, MapState};
    use x11rb::rust_connection::RustConnection;

    /// An X11 window by a connection of our own. The window library passes on only what some window managers say of a window
    /// (_NET_WM_STATE_HIDDEN); that a minimized one is not mapped holds for all (ICCCM 4.1.4).
    pub struct Server {
        connection: RustConnection,
        window: u32,
    }

    impl Server {
        /// `None` for windows of another kind.
        pub fn of(window: &Window) -> Option<Self> {
            let window = match window.window_handle().ok()?.as_raw() {
                RawWindowHandle::Xlib(handle) => u32::try_from(handle.window).ok()?,
                RawWindowHandle::Xcb(handle) => handle.window.get(),
                _ => return None,
            };
            let (connection, _) = x11rb::connect(None).ok()?;
            Some(Self { connection, window })
        }

        /// `None` if the server doesn't answer.
        pub fn is_mapped(&self) -> Option<bool> {
            let attributes = self.connection.get_window_attributes(self.window).ok()?.reply().ok()?;
            Some(attributes.map_state != MapState::UNMAPPED)
        }
    }
}
