//! `render --html`: the page in a headless browser. It turns by mouse, finger, slider and keys, loads nothing, and
//! complains of nothing. Without a browser the tests are skipped.

use std::path::Path;

use pellucid_testing::browser::{self, Browser};
use pellucid_testing::skip::{NO_BROWSER, skip};
use serde_json::Value;

use super::sequence::garden;
use crate::{done, has_device, inside};

const COUNT: usize = 8;

/// A page of the garden, whose folder lies where any browser sees it.
struct Page {
    browser: Browser,
    /// Canvas contents at each frame, set by the slider.
    pictures: Vec<Value>,
}

impl Page {
    /// Opens a page of 8 frames.
    fn open(more: &[&str]) -> Option<(Self, tempfile::TempDir)> {
        if !has_device() {
            return None;
        }
        let Some(program) = browser::find() else {
            skip(NO_BROWSER, "neither Chromium nor Chrome, nor is one named in CHROME");
            return None;
        };
        let folder = garden();
        let size = ["--method", "circles", "--size", "96x64", "--frames", "8", "--html", "view.html"];
        done(&folder, &[&["render", "garden/scene.toml"], &size[..], more].concat());
        let tmp = Path::new(env!("CARGO_TARGET_TMPDIR"));
        let place = tempfile::tempdir_in(tmp).unwrap();
        // Alone in its folder: nothing beside it is needed.
        let file = place.path().join("view.html");
        std::fs::copy(inside(&folder, "view.html"), &file).unwrap();
        let mut browser = Browser::start(&program, tmp);
        browser.open(&file);
        let own = format!("file://{}", file.display());
        assert!(browser.requests().iter().all(|url| *url == own), "{:?}", browser.requests());
        let mut page = Self { browser, pictures: Vec::new() };
        for frame in 0..COUNT {
            page.run(&format!(
                "const slider = document.querySelector('input'); slider.value = {frame}; slider.dispatchEvent(new Event('input'))"
            ));
            let shown = page.shown();
            page.pictures.push(shown);
        }
        for (number, picture) in page.pictures.iter().enumerate() {
            assert!(!page.pictures[..number].contains(picture), "frame {number} is another one");
        }
        Some((page, place))
    }

    fn run(&mut self, script: &str) {
        self.browser.evaluate(&format!("{{ {script} }}"));
        self.settle();
    }

    /// Waits until what was asked for is drawn.
    fn settle(&mut self) {
        self.browser.evaluate(
            "(async () => { for (const picture of document.querySelectorAll('#frames img')) await picture.decode();
               await new Promise((done) => requestAnimationFrame(() => setTimeout(done, 50))); })()",
        );
    }

    fn shown(&mut self) -> Value {
        self.settle();
        self.browser.evaluate("document.querySelector('canvas').toDataURL()")
    }

    /// The number of the picture that is shown, which is also said.
    fn frame(&mut self) -> usize {
        let shown = self.shown();
        let frame = self.pictures.iter().position(|picture| *picture == shown).expect("a picture of the page");
        let said = self.browser.evaluate("document.querySelector('output').value");
        assert_eq!(said, format!("frame {} of {COUNT}", frame + 1));
        assert_eq!(self.browser.evaluate("Number(document.querySelector('input').value)"), frame);
        frame
    }

    fn press(&mut self, element: &str, key: (&str, &str, u32)) -> usize {
        self.browser.press(element, key);
        self.frame()
    }

    /// Places in the canvas at a share of its width.
    fn at(&mut self, share: f64) -> [f64; 2] {
        let place = self.browser.evaluate(&format!(
            "(() => {{ const r = document.querySelector('canvas').getBoundingClientRect();
               return [r.x + {share} * r.width, r.y + 0.5 * r.height]; }})()"
        ));
        [0, 1].map(|axis| place[axis].as_f64().unwrap())
    }

    /// Drags over a share of the width and back, by mouse or by finger; the frame between.
    fn drag(&mut self, from: f64, to: f64, by: fn(&mut Browser, [f64; 2], [f64; 2])) -> usize {
        let [from, to] = [self.at(from), self.at(to)];
        by(&mut self.browser, from, to);
        self.frame()
    }
}

#[test]
fn a_turn_is_dragged_and_goes_around() {
    let Some((mut page, _place)) = Page::open(&["--turntable"]) else { return };
    let home = |page: &mut Page| assert_eq!(page.press("input", ("Home", "", 36)), 0);
    home(&mut page);
    // To the left by half of the width is half a turn; back it is where it was, and further it goes around.
    assert_eq!(page.drag(0.75, 0.25, Browser::drag), 4);
    assert_eq!(page.drag(0.25, 0.75, Browser::drag), 0);
    assert_eq!(page.drag(0.25, 0.5, Browser::drag), 6);
    home(&mut page);
    assert_eq!(page.drag(0.75, 0.5, Browser::swipe), 2);
    // A drag up or down is the page's own.
    assert_eq!(page.browser.evaluate("getComputedStyle(document.querySelector('canvas')).touchAction"), "pan-y");
    home(&mut page);
    for (key, code, frame) in
        [("ArrowRight", 39, 1), ("ArrowLeft", 37, 0), ("ArrowLeft", 37, 7), ("ArrowRight", 39, 0), ("End", 35, 7)]
    {
        assert_eq!(page.press("input", (key, "", code)), frame, "{key}");
    }
    // Keys are the page's, whatever has the focus.
    page.browser.evaluate("document.activeElement.blur()");
    assert_eq!(page.press("button", ("Home", "", 36)), 0);
    // Space plays, and Space again pauses.
    let text = |page: &mut Page| page.browser.evaluate("document.querySelector('button').textContent");
    page.browser.press("input", (" ", " ", 32));
    assert_eq!(text(&mut page), "Pause");
    let moved = page.browser.evaluate(
        "new Promise((done) => { const look = () => document.querySelector('output').value === 'frame 1 of 8' ? setTimeout(look, 10) : done(true); look(); })",
    );
    assert_eq!(moved, true);
    page.browser.press("input", (" ", " ", 32));
    assert_eq!(text(&mut page), "Play");
    page.frame();
    page.browser.click_at("button", [0.5, 0.5]);
    assert_eq!(text(&mut page), "Pause");
    page.browser.click_at("button", [0.5, 0.5]);
    assert_eq!((text(&mut page), page.browser.problems()), ("Play".into(), &[][..]));
}

#[test]
fn a_path_has_ends() {
    let Some((mut page, _place)) = Page::open(&["--path", "path.json"]) else { return };
    assert_eq!(page.press("input", ("Home", "", 36)), 0);
    assert_eq!(page.press("input", ("ArrowLeft", "", 37)), 0);
    assert_eq!(page.drag(0.1, 0.6, Browser::drag), 3);
    assert_eq!(page.drag(0.1, 0.9, Browser::drag), 7);
    assert_eq!(page.press("input", ("ArrowRight", "", 39)), 7);
    // It plays to its end and stops there, from the beginning if it was there.
    let stopped = "new Promise((done) => { const button = document.querySelector('button'); button.click();
        const look = () => button.textContent === 'Play' ? done(document.querySelector('output').value) : setTimeout(look, 10); look(); })";
    assert_eq!(page.browser.evaluate(stopped), "frame 8 of 8");
    assert_eq!(page.browser.problems(), &[] as &[String]);
}

#[test]
fn the_page_says_what_it_shows_and_fits_a_phone() {
    for (background, scheme, ink) in [("1,1,1", "light", "rgb(28, 28, 28)"), ("0,0,0.05", "dark", "rgb(237, 237, 237)")]
    {
        let Some((mut page, _place)) = Page::open(&["--turntable", "--background", background]) else { return };
        let browser = &mut page.browser;
        assert_eq!(browser.evaluate("getComputedStyle(document.documentElement).colorScheme"), scheme);
        assert_eq!(browser.evaluate("getComputedStyle(document.body).color"), ink);
        let corner = browser.evaluate(
            "[...document.querySelector('canvas').getContext('2d').getImageData(0, 0, 1, 1).data].slice(0, 3)",
        );
        let paper = browser.evaluate("getComputedStyle(document.body).backgroundColor.match(/\\d+/g).map(Number)");
        let apart = |channel: usize| corner[channel].as_i64().unwrap().abs_diff(paper[channel].as_i64().unwrap());
        // A JPEG may be some steps off.
        assert!((0..3).all(|channel| apart(channel) <= 4), "{corner} on {paper}");
        let text = browser.evaluate("document.querySelector('.about').textContent");
        let text = text.as_str().unwrap();
        for part in
            ["2\u{202f}828 points", "method circles", "8 pictures", "pellucid render garden/scene.toml", "--turntable"]
        {
            assert!(text.contains(part), "{part} in {text}");
        }
        assert_eq!(browser.evaluate("document.title"), browser.evaluate("document.querySelector('h1').textContent"));
        // Each control has a name.
        let names = browser.evaluate(
            "[document.querySelector('canvas').getAttribute('aria-label'), document.querySelector('input').getAttribute('aria-label'), document.querySelector('button').textContent]",
        );
        assert!((0..3).all(|at| names[at].as_str().is_some_and(|name| !name.is_empty())), "{names}");
        for width in [1400, 400, 320] {
            browser.resize(width);
            let hidden =
                browser.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth");
            assert_eq!(hidden, 0, "of {width} pixels");
            let shape = browser.evaluate(
                "(() => { const c = document.querySelector('canvas').getBoundingClientRect(); return c.width / c.height; })()",
            );
            assert!((shape.as_f64().unwrap() - 1.5).abs() < 0.02, "{shape}: the picture keeps its shape");
        }
        assert_eq!(browser.problems(), &[] as &[String]);
    }
}

#[test]
fn one_command_writes_a_film_and_a_page_and_frames_that_were_asked_for_stay() {
    if !has_device() {
        return;
    }
    let folder = garden();
    let base =
        ["render", "garden/scene.toml", "--method", "circles", "--size", "48x36", "--turntable", "--frames", "3"];
    done(&folder, &[&base[..], &["-o", "turn.gif", "--html", "turn.html"]].concat());
    assert!(["turn.gif", "turn.html"].iter().all(|name| inside(&folder, name).exists()));
    assert!(!inside(&folder, "turn.gif.frames").exists() && !inside(&folder, "turn.html.frames").exists());
    done(&folder, &[&base[..], &["-o", "f_%d.png", "--html", "more.html"]].concat());
    assert!(["f_0.png", "f_1.png", "f_2.png", "more.html"].iter().all(|name| inside(&folder, name).exists()));
    let page = std::fs::read_to_string(inside(&folder, "more.html")).unwrap();
    assert_eq!(page.matches("data:image/jpeg;base64,").count(), 3);
    assert!(page.ends_with("</html>") && !page.contains("http:") && !page.contains("https:"), "nothing of others");
}
