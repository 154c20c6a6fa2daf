//! Table 1: splats, one layer, soft transparency.

use std::fmt::Write;
use std::path::Path;

use pellucid_engine::Result;
use pellucid_engine::methods::Renderer;
use pellucid_gpu::Device;
use pellucid_lab::report::stress::Spread;
use pellucid_scene::{BlendedSplats, Method};

use super::scenes::SoftScene;
use super::{Contender, gpu_ms};

/// The paper's: name, million points, frames per second of SP, OLT and ST.
const PAPER: [(&str, f64, [f64; 3]); 9] = [
    ("RANDERSACKER", 27.2, [5.3, 2.9, 3.6]),
    ("LAND BUILDING", 16.0, [9.1, 5.4, 6.6]),
    ("CAECILIO", 10.8, [14.8, 8.0, 9.6]),
    ("MATTERPORT", 7.5, [19.1, 12.3, 15.5]),
    ("CASTLE", 7.4, [20.1, 11.4, 14.5]),
    ("SONGO MNARA", 6.4, [20.1, 12.5, 15.7]),
    ("TOWER", 5.5, [23.8, 14.7, 18.2]),
    ("CAIRN", 3.9, [46.4, 26.7, 31.9]),
    ("VINEYARDS", 1.2, [196.8, 150.1, 154.4]),
];

/// A line of the table.
pub struct Row {
    source: &'static str,
    name: String,
    points: f64,
    /// Milliseconds of SP, OLT and ST.
    ms: [f64; 3],
}

impl Row {
    /// Times of OLT and ST over the time of SP.
    fn ratios(&self) -> [f64; 2] {
        [self.ms[1] / self.ms[0], self.ms[2] / self.ms[0]]
    }
}

/// Renders the three in turns.
pub fn measure(device: &Device, subject: &SoftScene, frames: usize) -> Result<Row> {
    let mut cloud = Renderer::new(device)?.upload(&subject.points)?;
    let mut three = [
        Contender::new(device, "splats", Method::Splats(BlendedSplats::default()))?,
        Contender::new(device, "one-layer", subject.one_layer())?,
        Contender::new(device, "soft-express", Method::SoftExpress(subject.soft))?,
    ];
    let mut times = [const { Vec::new() }; 3];
    for round in 0..=frames {
        for (contender, times) in three.iter_mut().zip(&mut times) {
            let rendered = contender.render(&mut cloud, &subject.frame)?;
            // The first round pays for pipelines and buffers.
            if round > 0 {
                times.push(gpu_ms(&rendered));
            }
        }
    }
    let ms = times.map(|times| Spread::from_values(times).median);
    let row = Row { source: "pellucid", name: subject.name.clone(), points: subject.points.len() as f64, ms };
    let [one_layer, soft] = row.ratios();
    for (contender, ms) in three.iter().zip(ms) {
        println!("{:<14} {ms:10.2} ms", contender.name);
    }
    println!("one-layer / splats {one_layer:.2}, soft-express / splats {soft:.2}");
    Ok(row)
}

/// Writes `table.md` and `table.csv`.
pub fn write(folder: &Path, machine: &str, rows: &[Row]) -> Result<()> {
    let ms = |fps: [f64; 3]| fps.map(|fps| 1e3 / fps);
    let paper = PAPER.map(|(name, millions, fps)| Row {
        source: "Seemann et al. 2018, Table 1",
        name: name.to_owned(),
        points: 1e6 * millions,
        ms: ms(fps),
    });
    let (mut markdown, mut csv) = (format!("{machine}\n\n"), String::new());
    // Writing into a string can't fail.
    let _ = writeln!(markdown, "| source | scene | points | SP ms | OLT ms | ST ms | OLT / SP | ST / SP |");
    let _ = writeln!(markdown, "|---|---|---|---|---|---|---|---|");
    let _ = writeln!(csv, "source,scene,points,sp_ms,olt_ms,st_ms,olt_over_sp,st_over_sp");
    for row in rows.iter().chain(&paper) {
        let Row { source, name, points, ms: [sp, olt, st] } = row;
        let [one_layer, soft] = row.ratios();
        let _ = writeln!(
            markdown,
            "| {source} | {name} | {:.2} M | {sp:.1} | {olt:.1} | {st:.1} | {one_layer:.2} | {soft:.2} |",
            points / 1e6
        );
        let _ = writeln!(csv, "\"{source}\",\"{name}\",{points},{sp},{olt},{st},{one_layer},{soft}");
    }
    super::write(folder, "table.md", &markdown)?;
    super::write(folder, "table.csv", &csv)
}
