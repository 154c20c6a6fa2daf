// The view, as a copy that an entry point makes first of all: view = camera. A compiler that cannot rule out that a
// store changes the uniform loads every member again in every turn of a loop.
#import view

@group(0) @binding(0) var<uniform> camera: View;
var<private> view: View;
