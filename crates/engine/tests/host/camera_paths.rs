//! Camera paths of scenes: keys as cameras of a scene file, and the turntable.

mod exact;
mod turntable;
