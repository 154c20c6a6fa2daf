// Kinds of primitives of KERNEL_ELLIPSOID. BODY_DENSE: constant density inside, where a color's alpha is the optical
// depth of a unit of length. BODY_FLAT: a disc of opacity alpha, where the shortest axis is nothing. BODY_OPAQUE:
// nothing is seen through it.
const BODY_DENSE = 0.0;
const BODY_FLAT = 1.0;
const BODY_OPAQUE = 2.0;
