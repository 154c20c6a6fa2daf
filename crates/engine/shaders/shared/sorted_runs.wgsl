// The runs of sorted lists: bindings of the passes over them, and of one run its pixel in the image, and its fragments
// in the band's buffer, from the first to one behind the last. Imported after what binds the splats.
#import long_list
#import dispatch
@group(0) @binding(17) var<storage, read_write> work: LongWork;
@group(0) @binding(18) var<storage, read> runs: array<ListRun>;
@group(0) @binding(19) var<storage, read> fragments: array<vec2<u32>>;

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
