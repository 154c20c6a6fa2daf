//! The picture of each setting beside the reference.

use maud::{Markup, html};

use super::{Row, Tradeoff, error};
use crate::report::page::digits;
use crate::report::tradeoff::DIFFERENCE_GAIN;
use crate::report::tradeoff::pictures::Pictures;

/// The picture of a row over the reference, and the difference. The row with the median error is chosen at first, and
/// stays where no script runs.
pub(super) fn compared(report: &Tradeoff, pictures: &Pictures) -> Markup {
    let mut by_error: Vec<usize> = (0..report.rows.len()).collect();
    by_error.sort_by(|a, b| report.rows[*a].errors.rmse.total_cmp(&report.rows[*b].errors.rmse));
    let Some(&chosen) = by_error.get(by_error.len() / 2) else {
        return html! { p { "No setting was measured." } };
    };
    let [picture, difference] = pictures.rows[chosen];
    let [width, height] = pictures.size;
    let mut kinds: [Vec<usize>; 2] = std::array::from_fn(|kind| pictures.rows.iter().map(|row| row[kind]).collect());
    for kind in &mut kinds {
        kind.sort_unstable();
        kind.dedup();
    }
    let scale = match pictures.factor {
        1 => html! { "Pictures are shown with all their pixels." },
        n => html! {
            "Pictures are reduced to " (width) " × " (height) ": a pixel here is the mean of " (n) " × " (n)
            " pixels, in linear light, and in the differences the greatest of them, so that none is lost. The files beside this page "
            "have all pixels."
        },
    };
    html! {
        p { (scale) }
        p { label for="setting" { "Setting " } (choices(report, pictures, chosen)) }
        p #chosen aria-live="polite" { (about_row(&report.rows[chosen])) }
        div.pair {
            figure {
                div.stack #over {
                    img src=(pictures.uris[pictures.reference]) width=(width) height=(height) alt="the reference";
                    @for index in &kinds[0] {
                        img.above data-picture=(index) hidden[*index != picture] src=(pictures.uris[*index])
                            width=(width) height=(height) alt="the setting's picture, right of the cut";
                    }
                    span.edge {}
                    span.tag.left { "reference" }
                    span.tag.right { "setting" }
                }
                input.slider #cut type="range" min="0" max="100" step="any" value="50"
                    aria-label="where the reference ends and the setting's picture begins, in percent of the width";
                figcaption { b { "The reference, left, and the setting, right. " } "The slider moves the cut between them." }
            }
            figure {
                div.stack.still {
                    @for index in &kinds[1] {
                        img data-difference=(index) hidden[*index != difference] src=(pictures.uris[*index])
                            width=(width) height=(height) alt="the setting's difference from the reference";
                    }
                }
                figcaption { b { "Their absolute difference, " } (DIFFERENCE_GAIN) " times as bright." }
            }
        }
    }
}

fn choices(report: &Tradeoff, pictures: &Pictures, chosen: usize) -> Markup {
    html! {
        select #setting {
            @for (index, (row, [picture, difference])) in report.rows.iter().zip(&pictures.rows).enumerate() {
                option data-picture=(picture) data-difference=(difference) data-facts=(about_row(row))
                    selected[index == chosen] {
                    (row.name()) " — RMSE " (error(row.errors.rmse)) ", " (digits(row.gpu_ms.median)) " ms"
                }
            }
        }
    }
}

fn about_row(row: &Row) -> String {
    let Row { errors, gpu_ms, .. } = row;
    format!(
        "{}: RMSE {}, FLIP {}, largest error {}, {} ms; full size in {} and {}",
        row.name(),
        error(errors.rmse),
        error(errors.flip),
        error(errors.max),
        digits(gpu_ms.median),
        row.picture,
        row.difference,
    )
}
