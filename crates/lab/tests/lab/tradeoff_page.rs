//! The page of `tradeoff` in a headless browser: it draws, sorts and compares, loads nothing, and complains of nothing.
//! Without a browser the tests are skipped.

mod sample;

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use pellucid_io::output::read_image;
use pellucid_lab::report::tradeoff;
use pellucid_testing::browser::{self, Browser};
use pellucid_testing::skip::{NO_BROWSER, skip};
use serde_json::Value;

fn with_browser(test: impl FnOnce(&mut Browser)) {
    match browser::find() {
        Some(program) => test(&mut Browser::start(&program, Path::new(env!("CARGO_TARGET_TMPDIR")))),
        None => skip(NO_BROWSER, "neither Chromium nor Chrome, nor is one named in CHROME"),
    }
}

/// The folder of the report, written once for all tests and kept to be looked at.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("tradeoff-page");
        std::fs::create_dir_all(&folder).unwrap();
        let report = sample::report([660, 495]);
        sample::write_pictures(&folder, &report);
        tradeoff::write(&folder, &report).unwrap();
        folder
    })
}

/// The page alone in a folder of its own, after a change.
fn changed(change: impl Fn(&str) -> String) -> (tempfile::TempDir, PathBuf) {
    let page = std::fs::read_to_string(folder().join("report.html")).unwrap();
    let changed = change(&page);
    assert_ne!(changed, page, "nothing was changed");
    let alone = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let file = alone.path().join("report.html");
    std::fs::write(&file, changed).unwrap();
    (alone, file)
}

fn is_true(is: bool, what: &str) -> Result<(), String> {
    if is { Ok(()) } else { Err(what.to_owned()) }
}

/// The faults of a loaded page.
fn findings(browser: &mut Browser, file: &Path) -> Vec<String> {
    browser.open(file);
    let mut found: Vec<String> = browser.problems().iter().map(|problem| format!("console: {problem}")).collect();
    let own = format!("file://{}", file.display());
    found.extend(browser.requests().iter().filter(|url| **url != own).map(|url| format!("request: {url}")));
    let drawn = browser.evaluate(
        "[...document.querySelectorAll('figure svg')].map((svg) => {
           const shapes = [...svg.querySelectorAll('polyline, path, circle, polygon')];
           return [svg.getBoundingClientRect().width, shapes.filter((shape) => {
             const { width, height } = shape.getBoundingClientRect();
             return width + height > 0;
           }).length];
         })",
    );
    let drawn = drawn.as_array().unwrap();
    if drawn.len() != 6 {
        found.push(format!("plots: {} of 6", drawn.len()));
    }
    for (index, figure) in drawn.iter().enumerate() {
        // The least is that of bias and noise: three series of eleven points.
        if figure[0].as_f64() < Some(300.0) || figure[1].as_u64() < Some(33) {
            found.push(format!("plot {index}: width and shapes {figure}"));
        }
    }
    // Labels are texts, as are ticks and titles: none may lie over another.
    let overlaps = browser.evaluate(
        "[...document.querySelectorAll('figure svg')].flatMap((svg) => {
           const texts = [...svg.querySelectorAll('text')].map((t) => [t.textContent.trim(), t.getBoundingClientRect()]);
           return texts.flatMap(([a, p], i) => texts.slice(0, i).filter(([, q]) =>
             p.left < q.right && q.left < p.right && p.top + 2 < q.bottom && q.top + 2 < p.bottom,
           ).map(([b]) => `${a} over ${b}`));
         })",
    );
    found.extend(overlaps.as_array().unwrap().iter().map(|overlap| format!("texts: {overlap}")));
    let broken = browser.evaluate(
        "[...document.images].filter((i) => !i.hidden && !(i.complete && i.naturalWidth > 0 && i.clientWidth > 0)).length",
    );
    // The compared ones, and three around the worst place of each approximation.
    let shown = 3 + 3 * sample::LOOKS.len();
    if broken != 0 || browser.evaluate("[...document.images].filter((i) => !i.hidden).length") != shown {
        found.push(format!("pictures: {broken} of {shown} are not shown"));
    }
    found
}

#[test]
fn the_page_draws_loads_nothing_and_complains_of_nothing() {
    with_browser(|browser| {
        // Alone in a folder: nothing beside it is needed.
        let (_alone, file) = changed(|page| page.replace("</html>", "</html>\n"));
        assert_eq!(findings(browser, &file), Vec::<String>::new());
        // Only what is meant to is scrolled sideways, however narrow the window.
        for width in [1280, 480] {
            browser.resize(width);
            let hidden =
                browser.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth");
            assert_eq!(hidden, 0, "of {width} pixels");
        }
    });
}

#[test]
fn every_fault_of_a_page_is_found() {
    let in_body = |text: &'static str| move |page: &str| page.replace("<body>", &format!("<body>{text}"));
    let without_policy = |page: &str| page.replace("Content-Security-Policy", "nothing");
    let outside = in_body("<img hidden src=\"http://127.0.0.1:9/pixel.png\">");
    let first_plot = |page: &str, by: &str| {
        let (start, end) = (page.find("<svg").unwrap(), page.find("</svg>").unwrap());
        format!("{}{by}{}", &page[..start], &page[end + 6..])
    };
    type Fault = Box<dyn Fn(&str) -> String>;
    let faults: [(&str, Fault); 9] = [
        ("console: ", Box::new(in_body("<script>throw new Error('broken')</script>"))),
        ("console: ", Box::new(in_body("<script>console.error('broken')</script>"))),
        // The console reports requests that the policy refuses; others appear as requests.
        ("console: ", Box::new(outside)),
        ("request: http://127.0.0.1:9/pixel.png", Box::new(move |page| without_policy(&outside(page)))),
        ("plots: 5 of 6", Box::new(move |page| first_plot(page, ""))),
        ("plot 0: ", Box::new(move |page| first_plot(page, "<svg width='1140' height='620'></svg>"))),
        ("plot 0: ", Box::new(|page| page.replacen("<svg ", "<svg style='display: none' ", 1))),
        ("texts: ", Box::new(|page| page.replace("<text ", "<text style='font-size: 25px' "))),
        ("pictures: ", Box::new(|page| page.replace("data:image/png;base64,i", "data:image/png;base64,"))),
    ];
    with_browser(|browser| {
        for (index, (expected, fault)) in faults.iter().enumerate() {
            let (_alone, file) = changed(fault);
            let found = findings(browser, &file);
            assert!(found.iter().any(|finding| finding.starts_with(expected)), "fault {index}: {found:?}");
        }
    });
}

const TABLE: &str = "#settings table";

/// The texts of a column of the table of all settings.
fn column(browser: &mut Browser, index: usize) -> Vec<String> {
    let cells = browser.evaluate(&format!(
        "[...document.querySelectorAll('{TABLE} tbody tr')].map((r) => r.cells[{index}].textContent)"
    ));
    cells.as_array().unwrap().iter().map(|cell| cell.as_str().unwrap().to_owned()).collect()
}

fn head(browser: &mut Browser, title: &str) -> Result<usize, String> {
    let heads = browser.evaluate(&format!("[...document.querySelectorAll('{TABLE} th')].map((h) => h.textContent)"));
    heads.as_array().unwrap().iter().position(|head| head == title).ok_or(format!("no head {title}"))
}

/// A click on a head sorts by its numbers, a second one reverses, and so do keys.
fn sorts(browser: &mut Browser) -> Result<(), String> {
    let index = head(browser, "RMSE")?;
    let before = column(browser, index);
    let selector = format!("{TABLE} th:nth-child({}) button", index + 1);
    if browser.evaluate(&format!("document.querySelector({selector:?})")).is_null() {
        return Err("heads are no buttons".into());
    }
    let number = |text: &String| text.replace('−', "-").parse::<f64>().unwrap();
    let numbers = |texts: &[String]| texts.iter().map(number).collect::<Vec<_>>();
    let order = |browser: &mut Browser| {
        browser.evaluate(&format!("document.querySelector('{TABLE} th:nth-child({})').ariaSort", index + 1))
    };
    browser.click_at(&selector, [0.5; 2]);
    let ascending = column(browser, index);
    is_true(numbers(&ascending).is_sorted(), "not ascending")?;
    is_true(ascending != before && ascending.len() == before.len(), "as it was")?;
    is_true(order(browser) == "ascending", "aria-sort is not ascending")?;
    browser.click_at(&selector, [0.5; 2]);
    let descending = numbers(&column(browser, index));
    is_true(descending.is_sorted_by(|a, b| a >= b), "not descending")?;
    is_true(order(browser) == "descending", "aria-sort is not descending")?;
    browser.press(&selector, ("Enter", "\r", 13));
    is_true(column(browser, index) == ascending, "not ascending by keyboard")?;
    // The infinite PSNR of equal images is the greatest, though it is no number in JSON.
    let psnr = head(browser, "PSNR")?;
    for _ in 0..2 {
        browser.click_at(&format!("{TABLE} th:nth-child({}) button", psnr + 1), [0.5; 2]);
    }
    is_true(column(browser, psnr)[0] == "∞", "∞ is not the greatest")?;
    is_true(order(browser) == "none", "sorted by two columns")?;
    // Words by their letters, the numbers within them by value; what has no value comes last.
    browser.click_at(&format!("{TABLE} th:nth-child(2) button"), [0.5; 2]);
    let settings = column(browser, 1);
    let at = |name: &str| settings.iter().position(|setting| setting == name);
    is_true(at("samples=2").is_some() && at("samples=2") < at("samples=16"), "16 before 2")?;
    is_true(settings.last().is_some_and(String::is_empty), "empty settings are not last")
}

const SHOWN: &str = "['picture', 'difference'].map((kind) => [...document.querySelectorAll(`img[data-${kind}]`)]
    .filter((image) => image.clientWidth > 0).map((image) => image.src))";

fn cut(browser: &mut Browser) -> Value {
    browser.evaluate("getComputedStyle(document.querySelector('img.above:not([hidden])')).clipPath")
}

/// The slider cuts the picture, keys move it, so does a click on the picture; another setting brings other pictures.
fn compares(browser: &mut Browser) -> Result<(), String> {
    let input = |value: u32| {
        format!(
            "{{ const s = document.getElementById('cut'); s.value = {value}; s.dispatchEvent(new Event('input')); }}"
        )
    };
    is_true(cut(browser) == "inset(0px 0px 0px 50%)", "not cut in the middle at first")?;
    browser.evaluate(&input(20));
    is_true(cut(browser) == "inset(0px 0px 0px 20%)", "not cut at 20 %")?;
    browser.press("#cut", ("End", "", 35));
    is_true(cut(browser) == "inset(0px 0px 0px 100%)", "not cut at the end by keyboard")?;
    browser.click_at("#over", [0.25, 0.5]);
    let text = cut(browser);
    let percent = text.as_str().and_then(|text| text.strip_suffix("%)")?.rsplit(' ').next()?.parse::<f64>().ok());
    is_true(
        percent.is_some_and(|percent| (percent - 25.0).abs() < 0.5),
        &format!("a click in the picture gives {text}"),
    )?;

    let choose = |label: &str| {
        format!(
            "{{ const s = document.getElementById('setting');
               s.selectedIndex = [...s.options].findIndex((o) => o.text.startsWith({label:?}));
               s.dispatchEvent(new Event('change')); }}"
        )
    };
    let mut seen = Vec::new();
    for label in ["peel layers=2 ", "stochastic samples=64 ", "weighted "] {
        browser.evaluate(&choose(label));
        let shown = browser.evaluate(SHOWN);
        is_true([&shown[0], &shown[1]].iter().all(|s| s.as_array().is_some_and(|s| s.len() == 1)), "not one of each")?;
        is_true(!seen.contains(&shown[0]) && !seen.contains(&shown[1]), "the same pictures as before")?;
        seen.extend([shown[0].clone(), shown[1].clone()]);
        let text = browser.evaluate("document.getElementById('chosen').textContent");
        is_true(text.as_str().is_some_and(|t| t.starts_with(&format!("{}: RMSE", label.trim_end()))), "another text")?;
    }
    // Both are exact: their pictures are the same, and in the page once.
    browser.evaluate(&choose("abuffer "));
    let exact = browser.evaluate(SHOWN);
    browser.evaluate(&choose("linked-list "));
    is_true(browser.evaluate(SHOWN) == exact, "equal pictures differ")?;
    is_true(exact[0][0] == browser.evaluate("document.querySelector('#over img').src"), "an exact picture differs")
}

#[test]
fn tables_sort_and_pictures_are_compared() {
    with_browser(|browser| {
        browser.open(&folder().join("report.html"));
        assert_eq!(sorts(browser), Ok(()));
        assert_eq!(compares(browser), Ok(()));
        assert_eq!(browser.problems(), Vec::<String>::new());
        // Each check fails where a script does not run or does half of its work.
        type Check = fn(&mut Browser) -> Result<(), String>;
        let broken: [(Check, &str, &str); 7] = [
            (sorts, "head.append(button)", ""),
            (sorts, "isDescending ? -order : order", "order"),
            (
                sorts,
                "isText ? compareText(a, b) : (Number(a) > Number(b)) - (Number(a) < Number(b))",
                "compareText(a, b)",
            ),
            (sorts, "other.setAttribute(\"aria-sort\", \"none\")", "{}"),
            (compares, "slider.addEventListener(\"input\", cut)", ""),
            (compares, "image.hidden = ", "image.dataset.is = "),
            (compares, "document.getElementById(\"chosen\").textContent", "document.title"),
        ];
        for (check, good, bad) in broken {
            let (_alone, file) = changed(|page| page.replace(good, bad));
            browser.open(&file);
            assert!(check(browser).is_err(), "{good}");
        }
    });
}

#[test]
fn how_errors_look_is_told_in_two_sentences_with_the_worst_place() {
    let report = sample::report([660, 495]);
    let page = std::fs::read_to_string(folder().join("report.html")).unwrap();
    let start = page.find("How errors look").expect("the section");
    let section = &page[start..start + page[start..].find("<h2>").expect("another one")];
    let parts: Vec<&str> = section.split("<div class=\"look\">").skip(1).collect();
    assert_eq!(parts.len(), sample::LOOKS.len());
    for (part, (method, _)) in parts.iter().zip(sample::LOOKS) {
        let rows = report.rows.iter().filter(|row| row.method == method);
        let best = rows.min_by(|a, b| a.errors.rmse.total_cmp(&b.errors.rmse)).unwrap();
        let name = format!("{method} {}", best.setting.replace("method.", ""));
        assert!(part.starts_with(&format!("<h3>{}</h3>", name.trim_end())), "{name}: {}", &part[..80]);
        let text = &part[part.find("<p>").unwrap() + 3..part.find("</p>").unwrap()];
        assert_eq!(text.matches(". ").count() + usize::from(text.ends_with('.')), 2, "two sentences: {text}");
        let worst = best.look.unwrap().worst;
        let [exact, own, difference] = [&report.reference.picture, &best.picture, &best.difference].map(|name| {
            let image = read_image(&folder().join(name)).unwrap();
            let row = |y: u32| &image.pixels[(y * image.width + worst.x) as usize..][..worst.side as usize];
            (worst.y..worst.y + worst.side).flat_map(row).copied().collect::<Vec<_>>()
        });
        let embedded = part.split("data:image/png;base64,").skip(1).map(|rest| {
            let file = tempfile::Builder::new().suffix(".png").tempfile().unwrap();
            std::fs::write(file.path(), STANDARD.decode(&rest[..rest.find('"').unwrap()]).unwrap()).unwrap();
            read_image(file.path()).unwrap().pixels
        });
        assert!(embedded.eq([exact, own, difference]), "{name}");
    }
    let texts = ["98 % noise", "75 % leak", "60 % the opposite of leak", "90 % leak", "70 % ghosts"];
    for (part, text) in parts.iter().zip(texts) {
        assert!(part.contains(text), "{text}: {part}");
    }
    for term in ["Bias", "Even", "Leak", "Ghosts", "Noise"] {
        assert!(section.contains(&format!("<b>{term} </b>")), "{term} is not said to be something");
    }
}

#[test]
fn the_tables_for_programs_hold_every_row() {
    let report = sample::report([660, 495]);
    let text = std::fs::read_to_string(folder().join("tradeoff.json")).unwrap();
    // As text: reading numbers may cost them their last bit.
    assert!(text == serde_json::to_string_pretty(&report).unwrap() + "\n", "{text}");
    let read: tradeoff::Tradeoff = serde_json::from_str(&text).unwrap();
    assert_eq!((read.rows.len(), read.rows[0].errors.psnr), (report.rows.len(), None));
    let csv = csv::Reader::from_path(folder().join("tradeoff.csv")).unwrap();
    let lines: Vec<std::collections::HashMap<String, String>> =
        csv.into_deserialize().collect::<Result<_, _>>().unwrap();
    assert_eq!(lines.len(), report.rows.len() + report.skipped.len());
    for (line, row) in lines.iter().zip(&report.rows) {
        assert_eq!((&line["method"], &line["setting"], line["skipped"].as_str()), (&row.method, &row.setting, ""));
        assert_eq!(line["rmse"].parse(), Ok(row.errors.rmse));
        assert_eq!(line["gpu_ms_median"].parse(), Ok(row.gpu_ms.median));
        assert_eq!(line["bias"].parse().ok(), row.repeats.map(|repeats| repeats.bias));
    }
    assert_eq!(lines[0]["psnr"], "inf");
    let last = &lines[lines.len() - 1];
    assert_eq!((last["rmse"].as_str(), last["skipped"].as_str()), ("", report.skipped[1].reason.as_str()));
    let of_file = |name: &str| -> Vec<std::collections::HashMap<String, String>> {
        csv::Reader::from_path(folder().join(name)).unwrap().into_deserialize().map(Result::unwrap).collect()
    };
    let (causes, frames) = (of_file("causes.csv"), of_file("popping.csv"));
    assert_eq!((causes.len(), causes[1]["rmse"].as_str()), (2, "0.0123"));
    assert_eq!(
        (frames.len(), frames[0]["popping_rmse"].as_str(), frames[7]["popping_rmse"].as_str()),
        (80, "", "0.03")
    );
    for figure in ["error.svg", "flip.svg", "convergence.svg", "bias.svg", "popping.svg", "popping-flip.svg"] {
        assert!(std::fs::read_to_string(folder().join(figure)).unwrap().starts_with("<svg"), "{figure}");
    }
}

#[test]
fn a_missing_picture_is_named_and_leaves_no_page() {
    let empty = tempfile::tempdir().unwrap();
    let error = tradeoff::write(empty.path(), &sample::report([660, 495])).unwrap_err().to_string();
    assert!(error.contains("reference.png"), "{error}");
    assert_eq!(std::fs::read_dir(empty.path()).unwrap().count(), 0);
}

#[test]
fn nothing_measured_makes_a_page_too() {
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let full = sample::report([8, 6]);
    let report = tradeoff::Tradeoff { rows: Vec::new(), convergence: Vec::new(), ..full };
    sample::write_pictures(folder.path(), &report);
    tradeoff::write(folder.path(), &report).unwrap();
    with_browser(|browser| {
        browser.open(&folder.path().join("report.html"));
        assert_eq!(browser.problems(), Vec::<String>::new());
        assert_eq!(browser.evaluate("document.body.innerText.includes('No setting was measured.')"), true);
    });
}
