// What the ground's other images say between their samples, bilinearly. The includer declares `wetness`, `reef` and
// `openness`, all r32f and as large as `height`.
#ifndef FIELDS_GLSL
#define FIELDS_GLSL

// The four samples round a position and their weights.
struct Stencil {
    ivec2 first;
    ivec2 last;
    vec4 weights;   // of north-west, north-east, south-west, south-east
};

Stencil stencil(vec2 xz) {
    vec2 at = clamp(grid_position(xz), vec2(0.0), vec2(frame.cells - 1));
    ivec2 cell = ivec2(at);
    vec2 t = at - vec2(cell);
    vec2 s = 1.0 - t;
    return Stencil(cell, min(cell + 1, ivec2(frame.cells - 1)), vec4(s.x * s.y, t.x * s.y, s.x * t.y, t.x * t.y));
}

#define BILINEAR(field, s) \
    ((s).weights.x * imageLoad(field, (s).first) + (s).weights.y * imageLoad(field, ivec2((s).last.x, (s).first.y)) \
     + (s).weights.z * imageLoad(field, ivec2((s).first.x, (s).last.y)) + (s).weights.w * imageLoad(field, (s).last))

#endif
