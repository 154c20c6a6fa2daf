// Classes of pixels by the length of their list: each has its own kernel, work list and indirect dispatch.
// CLASS_COUNT and class_of are text that the host writes from its table (src/methods/abuffer.rs).

// Words of a class in the table: workgroups x, y, z; number of pixels; where its pixels begin in the work list; how many
// of them are in place; two unused.
const CLASS_WORDS = 8u;
const CLASS_TOTAL = 3u;
const CLASS_START = 4u;
const CLASS_PLACED = 5u;
// Pixels that one invocation classifies.
const CLASSIFY_RUN = 64u;
