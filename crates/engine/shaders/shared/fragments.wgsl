// Order of fragments: by depth key, then by the splat's canonical index, so that the order of arrival cannot show.
fn before(a: vec2<u32>, b: vec2<u32>) -> bool {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}
