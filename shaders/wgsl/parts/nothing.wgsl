// Zero, as compilers cannot know: dispatches are flat in z. Each entry point sets it first.
//
// A value that passes through an xor with it is neither contracted nor reassociated. A condition that does is
// not built into the shader anew for each dispatch, which Mesa's lavapipe (22.3) does with conditions on
// uniforms alone, taking 20 ms and losing 3 MB each time.
var<private> nothing: u32;
