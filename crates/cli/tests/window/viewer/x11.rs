//! Actions of other desktop programs on a window: they drop files onto it and ask for it to be maximized.

use std::fmt::Write;
use std::path::Path;
use std::time::{Duration, Instant};

use x11rb::connection::Connection;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    ClientMessageEvent, ConnectionExt, CreateWindowAux, EventMask, MapState, PropMode, SELECTION_NOTIFY_EVENT,
    SelectionNotifyEvent, SelectionRequestEvent, WindowClass,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;
use x11rb::{COPY_DEPTH_FROM_PARENT, COPY_FROM_PARENT, CURRENT_TIME};

/// Longest time that the window may take to answer.
const PATIENCE: Duration = Duration::from_secs(60);

/// A program on a display.
pub struct Client {
    connection: RustConnection,
    root: u32,
    own: u32,
}

impl Client {
    pub fn connect(display: &str) -> Self {
        let (connection, screen) = x11rb::connect(Some(display)).unwrap();
        let root = connection.setup().roots[screen].root;
        let own = connection.generate_id().unwrap();
        let plain = CreateWindowAux::new();
        let class = WindowClass::INPUT_ONLY;
        connection
            .create_window(COPY_DEPTH_FROM_PARENT, own, root, 0, 0, 1, 1, 0, class, COPY_FROM_PARENT, &plain)
            .unwrap();
        Self { connection, root, own }
    }

    fn atom(&self, name: &str) -> u32 {
        self.connection.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom
    }

    fn send(&self, to: u32, mask: EventMask, window: u32, kind: &str, data: [u32; 5]) {
        let message = ClientMessageEvent::new(32, window, self.atom(kind), data);
        self.connection.send_event(false, to, mask, message).unwrap();
        self.connection.flush().unwrap();
    }

    /// Asks the window manager to give a window all of the screen beside what it keeps for itself, or to take that
    /// back.
    pub fn maximize(&self, window: u32, maximized: bool) {
        let (across, down) = (self.atom("_NET_WM_STATE_MAXIMIZED_HORZ"), self.atom("_NET_WM_STATE_MAXIMIZED_VERT"));
        let mask = EventMask::SUBSTRUCTURE_REDIRECT | EventMask::SUBSTRUCTURE_NOTIFY;
        self.send(self.root, mask, window, "_NET_WM_STATE", [u32::from(maximized), across, down, 1, 0]);
    }

    /// Drops files onto a window, as freedesktop.org's XDND has it (version 5); returns when the window has taken them.
    #[track_caller]
    pub fn drop_files(&self, window: u32, files: &[&Path]) {
        let list = uri_list(files);
        let (selection, kind) = (self.atom("XdndSelection"), self.atom("text/uri-list"));
        self.connection.set_selection_owner(self.own, selection, CURRENT_TIME).unwrap();
        let none = EventMask::NO_EVENT;
        self.send(window, none, window, "XdndEnter", [self.own, 5 << 24, kind, 0, 0]);
        let at = 100 << 16 | 100;
        self.send(window, none, window, "XdndPosition", [self.own, 0, at, CURRENT_TIME, self.atom("XdndActionCopy")]);
        let (mut given, mut accepted) = (false, false);
        while !(given && accepted) {
            match self.next_event() {
                Event::SelectionRequest(request) => {
                    self.give(request, &list);
                    given = true;
                }
                Event::ClientMessage(message) if message.type_ == self.atom("XdndStatus") => {
                    accepted = message.data.as_data32()[1] & 1 == 1;
                    assert!(accepted, "the window takes no files");
                }
                _ => {}
            }
        }
        self.send(window, none, window, "XdndDrop", [self.own, 0, CURRENT_TIME, 0, 0]);
        let finished = self.atom("XdndFinished");
        while !matches!(self.next_event(), Event::ClientMessage(message) if message.type_ == finished) {}
    }

    /// Hands over what is dragged.
    fn give(&self, request: SelectionRequestEvent, list: &str) {
        let SelectionRequestEvent { requestor, selection, target, property, time, .. } = request;
        self.connection.change_property8(PropMode::REPLACE, requestor, property, target, list.as_bytes()).unwrap();
        let (response_type, sequence) = (SELECTION_NOTIFY_EVENT, 0);
        let notify = SelectionNotifyEvent { response_type, sequence, time, requestor, selection, target, property };
        self.connection.send_event(false, requestor, EventMask::NO_EVENT, notify).unwrap();
        self.connection.flush().unwrap();
    }

    #[track_caller]
    fn next_event(&self) -> Event {
        let until = Instant::now() + PATIENCE;
        loop {
            if let Some(event) = self.connection.poll_for_event().unwrap() {
                return event;
            }
            assert!(Instant::now() < until, "the window doesn't answer");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// The width and height of the window as the server has them.
    pub fn size(&self, window: u32) -> [u16; 2] {
        let geometry = self.connection.get_geometry(window).unwrap().reply().unwrap();
        [geometry.width, geometry.height]
    }

    /// Position of the window on the screen.
    pub fn position(&self, window: u32) -> [usize; 2] {
        let place = self.connection.translate_coordinates(window, self.root, 0, 0).unwrap().reply().unwrap();
        [place.dst_x, place.dst_y].map(|x| x.try_into().unwrap())
    }

    /// True if the window is mapped; a minimized one is not.
    pub fn is_mapped(&self, window: u32) -> bool {
        let attributes = self.connection.get_window_attributes(window).unwrap().reply().unwrap();
        attributes.map_state != MapState::UNMAPPED
    }
}

/// RFC 2483's list of files, with everything escaped that isn't plain.
fn uri_list(files: &[&Path]) -> String {
    let mut list = String::new();
    for file in files {
        list.push_str("file://");
        for byte in file.to_str().unwrap().bytes() {
            match byte {
                b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'.' | b'-' | b'_' => list.push(char::from(byte)),
                _ => write!(list, "%{byte:02X}").unwrap(),
            }
        }
        list.push_str("\r\n");
    }
    list
}
