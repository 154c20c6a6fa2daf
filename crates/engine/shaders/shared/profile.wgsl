// How opacity falls from the middle of a soft disc to its rim (Seemann et al. 2018, Eq. 19): (cos(pi d / r) + 1) / 2 by
// the square of d / r, in [0, 1]. It is cos² of half the angle, and that cosine is (1 - x) times a smooth function of x
// = (d / r)², here the minimax cubic for what comes out: 7e-8 off, 3e-7 with rounding, exactly 1 in the middle and 0 on
// the rim. src/methods/soft/express.rs holds it against the cosine.
fn profile(x: f32) -> f32 {
    let root = (1.0 - x) * (1.0 + x * (-0.233699319 + x * (0.0199576433 - 0.000863812306 * x)));
    return root * root;
}
