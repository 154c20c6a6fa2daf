// Classes of pixels by the length of their list: each has its own kernel, work list and indirect dispatch.
// CLASS_COUNT and class_of are text that the host writes from its table (src/methods/abuffer).
// The table has CLASS_WORDS words for each class, whose places src/methods/abuffer/blend/classes.rs names.
