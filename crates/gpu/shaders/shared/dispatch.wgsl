// Dispatches over more than 65 535 workgroups are folded over x and y.
fn workgroup_index(workgroup: vec3<u32>, groups: vec3<u32>) -> u32 {
    return workgroup.y * groups.x + workgroup.x;
}

fn invocation_index(workgroup: vec3<u32>, groups: vec3<u32>, local: u32) -> u32 {
    return workgroup_index(workgroup, groups) * WG_SIZE + local;
}
