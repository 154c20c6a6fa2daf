//! Files of key frames: what they say, and what is wrong with them.

use std::path::Path;

use pellucid_core::camera::path::{CameraPath, Key};

fn refused(text: &str) -> String {
    let error = CameraPath::from_json(text, Path::new("p.json")).expect_err(text);
    assert_eq!(error.exit_status(), 2);
    error.to_string()
}

#[test]
fn a_file_is_read_as_it_was_written() {
    let key = Key {
        time: Some(0.1),
        target: Some([1e-300, -2.5, 1.0 / 3.0]),
        up: Some([0.0, 1.0, 0.0]),
        fov_y: Some(33.3),
        near: Some(0.1),
        far: Some(1e6),
        ..Key::at([500_000.125, 4_500_000.25, 1.0])
    };
    let second = Key { time: Some(1.0), ..key.clone() };
    let path = CameraPath { size: Some([640, 360]), closed: true, ..CameraPath::new(vec![key, second]) };
    assert_eq!(CameraPath::from_json(&path.to_json(), Path::new("p.json")).unwrap(), path);
    let plain = CameraPath::new(vec![Key { orientation: Some([1.0, 0.0, 0.0, 0.0]), ..Key::at([1.0; 3]) }]);
    let text = plain.to_json();
    assert_eq!(CameraPath::from_json(&text, Path::new("p.json")).unwrap(), plain);
    assert!(!text.contains("loop") && !text.contains("null") && text.ends_with("}\n"), "{text}");
}

#[test]
fn syntax_errors_name_line_and_column() {
    for (text, place, says) in [
        ("", "p.json:1:0: ", "EOF"),
        ("[1, 2", "p.json:1:", ""),
        ("{\"version\": 1}", "p.json:1:14: ", "missing field `keys`"),
        ("{\"version\": 1,\n \"keys\": [], \"lop\": true}", "p.json:2:18: ", "unknown field `lop`, expected one of"),
        ("{\"version\": 1, \"keys\": [\n{\"eye\": [0, 1]}]}", "p.json:2:14: ", "array of length 3"),
        ("{\"version\": 1, \"keys\": [\n{\"eye\": [0, 1, NaN]}]}", "p.json:2:16: ", "NaN is not a number of JSON"),
        ("{\"version\": 1, \"keys\": [\n{\"eye\": [0, 1, 1e999]}]}", "p.json:2:20: ", "number out of range"),
        ("{\"version\": 1, \"keys\": [{\"eye\": [0, 1, \"2\"]}]}", "p.json:1:42: ", "invalid type: string"),
        ("{\"version\": 1, \"keys\": [{\"target\": [0, 1, 2]}]}", "p.json:1:45: ", "missing field `eye`"),
        ("{\"version\": 1, \"keys\": [], \"keys\": []}", "p.json:1:33: ", "duplicate field `keys`"),
        ("{\"version\": -1, \"keys\": []}", "p.json:1:14: ", "invalid value"),
    ] {
        let message = refused(text);
        assert!(message.starts_with(place) && message.contains(says) && !message.contains(" at line"), "{message}");
    }
    assert!(refused(&"[".repeat(100_000)).contains("p.json:1:"));
}

#[test]
fn values_that_make_no_path_name_their_key() {
    let key = |rest: &str| format!("{{\"version\": 1, \"keys\": [{{\"eye\": [0, 0, 5], {rest}}}]}}");
    let second = |rest: &str| {
        let target = "\"target\": [0, 0, 0]";
        format!(
            "{{\"version\": 1, \"keys\": [{{\"eye\": [0, 0, 5], \"time\": 1, {target}}}, {{\"eye\": [0, 0, 5], {target}{rest}}}]}}"
        )
    };
    for (text, says) in [
        ("{\"version\": 2, \"keys\": []}".to_owned(), "version: "),
        ("{\"version\": 1, \"keys\": []}".to_owned(), "keys: a path has from 1"),
        ("{\"version\": 1, \"size\": [0, 5], \"keys\": []}".to_owned(), "size: "),
        ("{\"version\": 1, \"size\": [100000, 5], \"keys\": []}".to_owned(), "16384"),
        (key("\"fov_y\": 45"), "keys[0]: needs a target or an orientation"),
        (key("\"target\": [0, 0, 5]"), "keys[0].target: must differ"),
        (key("\"target\": [0, 0, 1e80]"), "keys[0].target: must be"),
        (key("\"target\": [0, 0, 0], \"orientation\": [1, 0, 0, 0]"), "keys[0]: target and orientation"),
        (key("\"orientation\": [0, 0, 0, 0]"), "keys[0].orientation: "),
        (key("\"orientation\": [1e200, 0, 0, 0]"), "keys[0].orientation: "),
        (key("\"orientation\": [1, 0, 0, 0], \"up\": [0, 1, 0]"), "keys[0].up: belongs"),
        (key("\"target\": [0, 0, 0], \"up\": [0, 0, 0]"), "keys[0].up: must have"),
        (key("\"target\": [0, 0, 0], \"fov_y\": 180"), "keys[0].fov_y: "),
        (key("\"target\": [0, 0, 0], \"height\": 0"), "keys[0].height: "),
        (key("\"target\": [0, 0, 0], \"height\": 1, \"fov_y\": 40"), "keys[0]: fov_y"),
        (key("\"target\": [0, 0, 0], \"near\": -1"), "keys[0].near: "),
        (key("\"target\": [0, 0, 0], \"near\": 3, \"far\": 2"), "keys[0].near: must be less"),
        (second(""), "keys[1].time: either all"),
        (second(", \"time\": 1"), "keys[1].time: times must ascend: 1 follows 1"),
        (second(", \"time\": 2, \"far\": 9"), "keys[1].far: either all"),
    ] {
        let message = refused(&text);
        assert!(message.starts_with("p.json: ") && message.contains(says), "{message} for {says}");
    }
}
