//! `pellucid-mpi plan`: how the ranks would share the work, and why.

use pellucid_session::Prepared;
use serde_json::json;

use super::ranks::Ranks;
use super::share::{Offer, time};
use super::stage::RankScene;
use crate::commands::Error;
use crate::commands::console::Console;
use crate::commands::mpi_args::SharingArgs;
use crate::commands::plan::PlanArgs;

/// Prints what the ranks can share, with what it is expected to take, and what each of them would render.
///
/// # Errors
/// Errors of reading the scene.
pub fn run(
    args: &PlanArgs,
    sharing: &SharingArgs,
    count: Option<usize>,
    ranks: &Ranks,
    console: Console,
) -> Result<(), Error> {
    let progress = console.progress();
    let prepare = || {
        let request = args.input.request(None, &progress)?;
        Ok((Prepared::new(request, &progress, &progress)?, 1))
    };
    let mut stage = RankScene::open((&args.device, sharing.share), ranks, &progress, prepare)?;
    progress.finish_and_clear();
    if !ranks.is_first() {
        return Ok(());
    }
    let count = count.unwrap_or(ranks.count());
    let (job, link) = (stage.job, stage.link);
    let share = job.choose(sharing.share, count, link)?;
    let windows = stage.cut(count);
    let costs = stage.costs();
    let work: Vec<f64> = windows.iter().map(|window| costs.of(*window).work).collect();
    let all = costs.whole().work.max(1.0);
    let offers = job.offers(count, link);
    if args.json {
        console.print_json(&json!({
            "ranks": count,
            "share": share.to_string(),
            "latency_s": link.latency,
            "bandwidth": link.bandwidth,
            "load": {"points": job.load.points, "fragments": job.load.fragments, "pixels": job.load.pixels, "slots": job.slots},
            "offers": offers.iter().map(|o| json!({"share": o.share.to_string(), "seconds": o.seconds, "why": o.why})).collect::<Vec<_>>(),
            "windows": windows.iter().zip(&work).map(|(window, work)| json!({"window": window, "share": work / all})).collect::<Vec<_>>(),
        }))?;
        return Ok(());
    }
    let line = |offer: &Offer| {
        let mark = if offer.share == share { "on " } else { "off" };
        let seconds = offer.seconds.map_or_else(|| "not possible".to_owned(), time);
        format!("{:<10} {mark} {seconds}: {}\n", offer.share.to_string(), offer.why)
    };
    let mut text: String = offers.iter().map(line).collect();
    text += &format!(
        "expected: {:.0} visible points, {:.0} fragments; one rank takes {}; messages: {} each, {:.2} GB/s{}\n",
        job.load.points,
        job.load.fragments,
        time(job.alone()),
        time(link.latency),
        1e-9 * link.bandwidth,
        if ranks.count() > 1 { ", as measured" } else { " (assumed, not measured)" },
    );
    for (at, ([x0, y0, x1, y1], work)) in windows.iter().zip(&work).enumerate() {
        let whose = if at < count { format!("rank {at}") } else { "on demand".to_owned() };
        text +=
            &format!("{whose:<10} columns {x0} to {x1}, rows {y0} to {y1}: {:.1} % of the work\n", 100.0 * work / all);
    }
    console.print(&text)?;
    Ok(())
}
