// Where a list with Gaussians ends before its last fragment (Kerbl et al. 2023): at the first one that would leave less
// than a given share of the light. That one is not added, and none behind it. Imported after the view.
// Reference: reference::abuffer::before_end.
#import over

// True if a list ends at the fragment with which A is this. Where no end is asked for, the share is 0: A is at most 1.
fn is_end(a: f32) -> bool {
    return has_gaussians() && 1.0 - a < view.forward.w;
}
