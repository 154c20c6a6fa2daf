//! The causes of errors as tables.

use std::io::{self, Write};

use maud::{Markup, html};
use serde::Serialize;

use super::Cause;
use crate::report::page::{Column, digits, table};
use crate::report::tradeoff::figures::short;
use crate::report::tradeoff::page::{error, percent};

/// A line of `causes.csv`.
#[derive(Debug, Serialize)]
struct Line<'a> {
    cause: &'a str,
    setting: &'a str,
    against: &'a str,
    rmse: f64,
    flip: f64,
    max: f64,
    above_1_255: f64,
    gpu_ms: f64,
    difference: &'a str,
    meaning: &'a str,
}

/// The table for programs.
pub(in super::super) fn csv(causes: &[Cause], file: impl Write) -> io::Result<()> {
    let mut writer = csv::Writer::from_writer(file);
    for cause in causes {
        let line = Line {
            cause: &cause.cause,
            setting: &cause.setting,
            against: &cause.against,
            rmse: cause.rmse,
            flip: cause.flip,
            max: cause.max,
            above_1_255: cause.above_1_255,
            gpu_ms: cause.gpu_ms,
            difference: &cause.difference,
            meaning: &cause.meaning,
        };
        writer.serialize(line).map_err(io::Error::other)?;
    }
    writer.flush()
}

/// The section of the page; nothing without causes.
pub(in super::super) fn page(causes: &[Cause]) -> Markup {
    let columns = [
        Column::text("cause"),
        Column::text("setting"),
        Column::number("RMSE"),
        Column::number("FLIP"),
        Column::number("largest"),
        Column::number("% off"),
        Column::number("ms"),
        Column::text("what it means"),
    ];
    let row = |cause: &Cause| {
        vec![
            cause.cause.clone(),
            changed(cause),
            error(cause.rmse),
            error(cause.flip),
            error(cause.max),
            percent(cause.above_1_255),
            digits(cause.gpu_ms),
            cause.meaning.clone(),
        ]
    };
    html! {
        @if !causes.is_empty() {
            h2 { "Error by cause" }
            p {
                "The table shows what each approximation of Gaussian splats does to this image by itself. Each row changes one thing "
                "of the image of " code { "abuffer" } " and compares it with the exact image of the scene's own kernel and order. "
                "“Exact” holds for these; which of two images looks better depends on how the splats were trained. “% off” is the "
                "share of pixels with a channel off by more than 1/255; times are the shorter of two frames. "
                code { "cause-….png" } " beside this page show where the differences are."
            }
            div.sentences { (table(&columns, &causes.iter().map(row).collect::<Vec<_>>())) }
        }
    }
}

/// The setting, and what it is compared with if that is not the scene's image.
pub(super) fn changed(cause: &Cause) -> String {
    match cause.against.as_str() {
        "" => short(&cause.setting),
        against => format!("{} against {}", short(&cause.setting), short(against)),
    }
}
