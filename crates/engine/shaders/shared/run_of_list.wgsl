// One run of a list: its pixel in the image, and its fragments in the band's buffer, from the first to one behind the
// last.
#import long_list

fn pixel_of_run(run: ListRun) -> vec2<u32> {
    let width = view.window.z - view.window.x;
    return view.window.xy + vec2<u32>(run.pixel % width, run.pixel / width);
}

fn start_of_run(run: ListRun) -> u32 {
    return run.start + run.run * RUN_LENGTH;
}

fn end_of_run(run: ListRun) -> u32 {
    return run.start + min((run.run + 1u) * RUN_LENGTH, run.length);
}
