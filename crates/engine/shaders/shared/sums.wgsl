// Sums of any length: what rounding makes of a sum is noted and put right with the next term (Kahan 1965), so that no
// number of small terms gets lost. Relies on every operation being rounded by itself, as shared/twofloat does.
struct Sum {
    total: vec4<f32>,
    // By how much the total is too large.
    excess: vec4<f32>,
}

// Nothing changes nothing, not even how the excess is spread: which splats come by without covering a pixel depends on
// where its tile lies.
fn plus(sum: Sum, term: vec4<f32>) -> Sum {
    let wanted = term - sum.excess;
    let total = sum.total + wanted;
    let excess = (total - sum.total) - wanted;
    let any_term = any(term != vec4<f32>(0.0));
    return Sum(select(sum.total, total, any_term), select(sum.excess, excess, any_term));
}

// 1 - ∏(1 - α) and by how much it is too large, with one factor more. It grows by α (1 - A): a product would round
// small opacities away.
fn covered(a: vec2<f32>, alpha: f32) -> vec2<f32> {
    let wanted = alpha * ((1.0 - a.x) + a.y) - a.y;
    let total = a.x + wanted;
    return select(a, vec2<f32>(total, (total - a.x) - wanted), alpha != 0.0);
}
