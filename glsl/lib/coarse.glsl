// The grid on which light and surf are found: the ground's own, or a coarser one where that would be needlessly fine.
#ifndef COARSE_GLSL
#define COARSE_GLSL

layout(push_constant, scalar) uniform Push {
    int cells;   // along one side
    int first;   // row that the first invocations are of
} push;

ivec2 coarse_at() {
    return ivec2(gl_GlobalInvocationID.xy) + ivec2(0, push.first);
}

float coarse_cell_size() {
    return frame.extent / float(push.cells - 1);
}

vec2 coarse_position(ivec2 at) {
    return vec2(at) * coarse_cell_size() - 0.5 * frame.extent;
}

// The sample of the ground nearest to one of the coarse grid; exactly that sample where both grids are the same.
ivec2 ground_cell(ivec2 at) {
    return push.cells == frame.cells ? at : ivec2(round(vec2(at) * float(frame.cells - 1) / float(push.cells - 1)));
}

bool on_coarse_grid(ivec2 at) {
    return all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(push.cells)));
}

#endif
