//! Detects if a window is minimized, because a minimized window need not be drawn.

use winit::window::Window;

/// A window whose state can be asked for.
pub struct Visibility {
    #[cfg(all(unix, not(target_vendor = "apple")))]
    server: Option<x11::Server>,
}

impl Visibility {
    pub fn for_window(window: &Window) -> Self {
        #[cfg(not(all(unix, not(target_vendor = "apple"))))]
        let _ = window;
        Self {
            #[cfg(all(unix, not(target_vendor = "apple")))]
            server: x11::Server::for_window(window),
        }
    }

    /// True if the system reports the window as minimized. Wayland doesn't report it.
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

    /// A separate connection for an X11 window. The window library relies on _NET_WM_STATE_HIDDEN, which only some
    /// window managers set; that a minimized window is unmapped holds for all (ICCCM 4.1.4).
    pub struct Server {
        connection: RustConnection,
        window: u32,
    }

    impl Server {
        /// `None` for windows of other systems.
        pub fn for_window(window: &Window) -> Option<Self> {
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
