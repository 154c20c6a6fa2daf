// Goes through the list of large squares: push.stripes workgroups for each of them.
override STRIPES: u32 = 1u;

#main {
    view = camera;
    let group = workgroup_index(workgroup, groups);
    let square = group / STRIPES;
    if square >= atomicLoad(&counters[0].large) {
        return;
    }
    let square_of = large[2u * square];
    let rectangle = large[2u * square + 1u];
    let width = rectangle.z - rectangle.x;
    let area = width * (rectangle.w - rectangle.y);
    for (var p = (group % STRIPES) * WG_SIZE + local; p < area; p += STRIPES * WG_SIZE) {
        let pixel = vec2<u32>(rectangle.x + p % width, rectangle.y + p / width);
        visit(square_of.x, square_of.y, square_of.z, window_index(pixel, view.window));
    }
}
