//! A headless browser, driven by the DevTools protocol.

use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket};

/// No step takes as long, however busy the machine is.
const PATIENCE: Duration = Duration::from_secs(60);

/// The browser that `CHROME` names, or the first that is installed.
pub fn find() -> Option<PathBuf> {
    if let Some(path) = std::env::var_os("CHROME") {
        return Some(path.into());
    }
    let path = std::env::var_os("PATH")?;
    let names = ["google-chrome", "chromium", "chromium-browser"];
    // Every folder for the first name, then for the next: Ubuntu's `chromium` is a snap, which sees few folders.
    names.iter().find_map(|name| std::env::split_paths(&path).map(|folder| folder.join(name)).find(|p| p.is_file()))
}

/// A running browser with one page. It ends with the value.
pub struct Browser {
    process: Child,
    socket: WebSocket<TcpStream>,
    session: Option<String>,
    calls: u64,
    is_loaded: bool,
    problems: Vec<String>,
    requests: Vec<String>,
    // Dropped last: the browser writes into it as long as it runs.
    _profile: tempfile::TempDir,
}

impl Browser {
    /// Starts a browser with a profile of its own, in a folder, and an empty page. The folder is not the system's for
    /// temporary files, which a snap does not see.
    pub fn start(program: &Path, folder: &Path) -> Self {
        let profile = tempfile::tempdir_in(folder).unwrap();
        let mut process = Command::new(program)
            // Root has no sandbox, and the only page is our own.
            .args(["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run"])
            .args(["--disable-background-networking", "--disable-component-update", "--disable-extensions"])
            .args(["--remote-debugging-port=0", "--window-size=1280,1000"])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg("about:blank")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap_or_else(|error| panic!("{}: {error}", program.display()));
        let (port, path) = endpoint(profile.path(), &mut process);
        let stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let (socket, _) = tungstenite::client(format!("ws://127.0.0.1:{port}{path}"), stream).unwrap();
        let mut browser = Self {
            process,
            socket,
            session: None,
            calls: 0,
            is_loaded: false,
            problems: Vec::new(),
            requests: Vec::new(),
            _profile: profile,
        };
        let target = browser.call("Target.createTarget", json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        let attached = browser.call("Target.attachToTarget", attach);
        browser.session = attached["sessionId"].as_str().map(str::to_owned);
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        browser
    }

    /// Opens a file and waits until it is loaded; what was recorded of the page before is forgotten.
    pub fn open(&mut self, file: &Path) {
        self.problems.clear();
        self.requests.clear();
        self.is_loaded = false;
        let url = format!("file://{}", file.display());
        let answer = self.call("Page.navigate", json!({ "url": url }));
        assert_eq!(answer["errorText"], Value::Null, "{url}");
        while !self.is_loaded {
            let message = self.read();
            self.note(&message);
        }
        // Messages that are on their way come before the answer.
        self.evaluate("new Promise((done) => requestAnimationFrame(() => setTimeout(done, 100)))");
    }

    /// Errors and warnings on the console, exceptions, and what the page's policy refused.
    pub fn problems(&self) -> &[String] {
        &self.problems
    }

    /// Addresses that the page asked for, its own among them, except those that it carries itself.
    pub fn requests(&self) -> &[String] {
        &self.requests
    }

    /// Makes the page so many pixels wide.
    pub fn resize(&mut self, width: u32) {
        let metrics = json!({ "width": width, "height": 1000, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", metrics);
    }

    /// The value of an expression, or of the promise that it is.
    pub fn evaluate(&mut self, expression: &str) -> Value {
        let question = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let answer = self.call("Runtime.evaluate", question);
        assert_eq!(answer["exceptionDetails"], Value::Null, "{expression}");
        answer["result"]["value"].clone()
    }

    /// A click with the left button at a place of an element, as shares of its width and height.
    pub fn click_at(&mut self, selector: &str, [x, y]: [f64; 2]) {
        let rectangle = self.evaluate(&format!(
            "(() => {{ const e = document.querySelector({selector:?}); e.scrollIntoView({{ block: 'center' }});
               const r = e.getBoundingClientRect(); return [r.x + {x} * r.width, r.y + {y} * r.height]; }})()"
        ));
        for kind in ["mousePressed", "mouseReleased"] {
            let [x, y] = [&rectangle[0], &rectangle[1]];
            let event = json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1 });
            self.call("Input.dispatchMouseEvent", event);
        }
    }

    /// Gives an element the focus and presses a key, as `("Enter", "\r", 13)`.
    pub fn press(&mut self, selector: &str, (key, text, code): (&str, &str, u32)) {
        self.evaluate(&format!("document.querySelector({selector:?}).focus()"));
        for kind in ["keyDown", "keyUp"] {
            let event = json!({ "type": kind, "key": key, "code": key, "text": text, "windowsVirtualKeyCode": code });
            self.call("Input.dispatchKeyEvent", event);
        }
    }

    /// Presses the left button at a place of the page, moves to another in steps and lets go.
    pub fn drag(&mut self, from: [f64; 2], to: [f64; 2]) {
        let mut event = |kind: &str, [x, y]: [f64; 2], held: u32| {
            let event = json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": held, "clickCount": 1 });
            self.call("Input.dispatchMouseEvent", event);
        };
        event("mousePressed", from, 1);
        between(from, to).for_each(|place| event("mouseMoved", place, 1));
        event("mouseReleased", to, 0);
    }

    /// Drags by touch, with a finger.
    pub fn swipe(&mut self, from: [f64; 2], to: [f64; 2]) {
        let mut event = |kind: &str, points: Value| {
            self.call("Input.dispatchTouchEvent", json!({ "type": kind, "touchPoints": points }));
        };
        event("touchStart", json!([{ "x": from[0], "y": from[1] }]));
        between(from, to).for_each(|[x, y]| event("touchMove", json!([{ "x": x, "y": y }])));
        event("touchEnd", json!([]));
    }

    fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.calls += 1;
        let mut message = json!({ "id": self.calls, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        self.socket.send(Message::text(message.to_string())).unwrap();
        loop {
            let message = self.read();
            if message["id"] == self.calls {
                assert_eq!(message["error"], Value::Null, "{method}");
                return message["result"].clone();
            }
            self.note(&message);
        }
    }

    fn read(&mut self) -> Value {
        loop {
            if let Message::Text(text) = self.socket.read().expect("an answer of the browser") {
                return serde_json::from_str(&text).unwrap();
            }
        }
    }

    fn note(&mut self, event: &Value) {
        let parameters = &event["params"];
        match event["method"].as_str() {
            Some("Page.loadEventFired") => self.is_loaded = true,
            Some("Runtime.exceptionThrown") => self.problems.push(parameters["exceptionDetails"].to_string()),
            Some("Runtime.consoleAPICalled") if parameters["type"] != "log" => {
                self.problems.push(parameters["args"].to_string());
            }
            Some("Log.entryAdded") => self.problems.push(parameters["entry"]["text"].to_string()),
            Some("Network.requestWillBeSent") => {
                let url = parameters["request"]["url"].as_str().unwrap_or_default();
                if !url.starts_with("data:") {
                    self.requests.push(url.to_owned());
                }
            }
            _ => {}
        }
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Places on the way from one to another, which is the last of them.
fn between(from: [f64; 2], to: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
    const STEPS: u32 = 8;
    (1..=STEPS).map(move |step| {
        let share = f64::from(step) / f64::from(STEPS);
        [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
    })
}

/// Port and path of the browser's socket, which it writes into its profile.
fn endpoint(profile: &Path, process: &mut Child) -> (u16, String) {
    let since = Instant::now();
    loop {
        let text = std::fs::read_to_string(profile.join("DevToolsActivePort")).unwrap_or_default();
        let mut lines = text.lines();
        if let (Some(Ok(port)), Some(path)) = (lines.next().map(str::parse), lines.next()) {
            return (port, path.to_owned());
        }
        assert_eq!(process.try_wait().unwrap(), None, "the browser ended");
        assert!(since.elapsed() < PATIENCE, "the browser does not answer");
        std::thread::sleep(Duration::from_millis(20));
    }
}
