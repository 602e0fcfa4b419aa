#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// First half of an iteration of hydraulic erosion: sediment travels with the last fluxes, it rains, and the virtual pipes
// accelerate (Mei, Decaudin & Hu 2007; Korošec & Lebar Bajec (6–9, 17)).

#include "lib/pipes.glsl"

layout(local_size_x = 64, local_size_y = 1) in;
// Outside an open rim lies dry ground at the rim's own height.
layout(constant_id = 2) const bool OPEN = false;
// Cross-section of a pipe per width: the whole pipe depth, or as much of it as the flow fills.
layout(constant_id = 3) const bool FIXED_SECTION = false;
layout(constant_id = 4) const bool DRAG = true;
// The slope in the capacity: of the ground by central differences, or the drop of the water surface weighted by outflow.
layout(constant_id = 5) const bool CENTRAL_SLOPE = false;
// Sediment leaves with the water, or is traced back along the velocity.
layout(constant_id = 6) const bool SEMI_LAGRANGIAN = false;

layout(binding = 0, r32f) uniform readonly image2D height;
layout(binding = 1, rgba32f) uniform readonly image2D water; // depth, sediment per unit of flux, discharge, wetness
layout(binding = 2, r32f) uniform readonly image2D sediment_in;
layout(binding = 3, r32f) uniform writeonly image2D sediment_out;
layout(binding = 4, rgba32f) uniform readonly image2D axis_in;
layout(binding = 5, rgba32f) uniform writeonly image2D axis_out;
layout(binding = 6, rgba32f) uniform readonly image2D diagonal_in;
layout(binding = 7, rgba32f) uniform writeonly image2D diagonal_out;
layout(binding = 8, r32f) uniform writeonly image2D slope;
layout(binding = 9, rg32f) uniform readonly image2D velocity;
layout(binding = 10, rgba32f) uniform readonly image2D controls;
layout(push_constant, scalar) uniform Push {
    float cell_size;
    float time_step;
    float sea_level;
    float rain; // in one step, m
    float gravity;
    float pipe_depth;
    float drag;
} push;

// A cell's fluxes through four pipes after one step (Korošec & Lebar Bajec (7, 8)). The friction of the bed is
// quadratic in the speed and solved implicitly: u' = 2a/(1 + √(1 + 4·m·a)), m = τ·c_f·ρ/δ².
vec4 accelerate(vec4 flux, float ground, float surface, vec4 ground_n, vec4 surface_n, float steepest, float pipe_length,
                float width) {
    precise vec4 drop = surface - surface_n;
    vec4 depth = clamp(max(vec4(surface), surface_n) - max(vec4(ground), ground_n), vec4(0.0), vec4(push.pipe_depth));
    vec4 section = FIXED_SECTION ? vec4(push.pipe_depth) : depth;
    precise vec4 pushed = flux * (1.0 / width) + push.time_step * push.gravity / pipe_length * (section * drop);
    vec4 discharge = max(vec4(0.0), pushed);
    if (DRAG) {
        // ρ: the gradient of the water surface over its share along the pipe.
        vec4 share = mix(vec4(1.0), clamp(steepest * pipe_length / drop, vec4(1.0), vec4(10.0)), greaterThan(drop, vec4(0.0)));
        precise vec4 root = depth * depth + 4.0 * push.time_step * push.drag * (share * discharge);
        discharge = 2.0 * discharge * depth / max(depth + sqrt(root), vec4(1e-30));
    } else {
        discharge = mix(vec4(0.0), discharge, greaterThan(section, vec4(0.0)));
    }
    return width * discharge;
}

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(height);
    if (outside(cell, size)) return;

    Stencil at = stencil(cell, size);
    float ground = imageLoad(height, cell).x;
    vec4 own = imageLoad(water, cell);
    vec4 ground_axis = AXIS(height, at);
    vec4 ground_diagonal = DIAGONAL(height, at);
    mat4 water_axis = AXIS4(water, at);
    mat4 water_diagonal = DIAGONAL4(water, at);
    vec4 axis = imageLoad(axis_in, cell);
    vec4 diagonal = PIPES == 8u ? imageLoad(diagonal_in, cell) : vec4(0.0);

    // Transport (17).
    float sediment = imageLoad(sediment_in, cell).x;
    if (SEMI_LAGRANGIAN) {
        // At most one cell far, so that the bilinear sample is a weighted mean of the neighbourhood.
        precise vec2 back = -imageLoad(velocity, cell).xy * push.time_step / push.cell_size;
        vec2 before = max(-back, vec2(0.0));
        vec2 after = max(back, vec2(0.0));
        vec2 stay = 1.0 - abs(back);
        vec4 weight_axis = vec4(before.x * stay.y, after.x * stay.y, stay.x * before.y, stay.x * after.y);
        vec4 weight_diagonal = vec4(before.x * before.y, after.x * before.y, before.x * after.y, after.x * after.y);
        precise float moved = stay.x * stay.y * sediment
            + sum(weight_axis * AXIS(sediment_in, at), weight_diagonal * DIAGONAL(sediment_in, at));
        sediment = moved;
    } else {
        vec4 into_axis = AXIS_INFLOW(axis_in, at) * water_axis[1];
        vec4 into_diagonal = PIPES == 8u ? DIAGONAL_INFLOW(diagonal_in, at) * water_diagonal[1] : vec4(0.0);
        precise float carried = max(0.0, sediment - own.y * sum(axis, diagonal)) + sum(into_axis, into_diagonal);
        sediment = carried;
    }

    // Rain (6).
    float rain = push.rain;
    vec4 rain_axis = vec4(push.rain);
    vec4 rain_diagonal = vec4(push.rain);
    if (CONTROLS) {
        rain *= imageLoad(controls, cell).x;
        rain_axis *= AXIS(controls, at);
        rain_diagonal *= DIAGONAL(controls, at);
    }
    float depth = rained(own.x, ground, rain, push.sea_level);
    float surface = ground < push.sea_level ? push.sea_level : ground + depth;
    vec4 surface_axis = mix(ground_axis + (water_axis[0] + rain_axis), vec4(push.sea_level),
                            lessThan(ground_axis, vec4(push.sea_level)));
    vec4 surface_diagonal = mix(ground_diagonal + (water_diagonal[0] + rain_diagonal), vec4(push.sea_level),
                                lessThan(ground_diagonal, vec4(push.sea_level)));
    float steepest = DRAG ? gradient(surface_axis, push.cell_size) : 0.0;
    if (OPEN) {
        ground_axis = mix(vec4(ground), ground_axis, at.axis);
        ground_diagonal = mix(vec4(ground), ground_diagonal, at.diagonal);
        surface_axis = mix(vec4(ground), surface_axis, at.axis);
        surface_diagonal = mix(vec4(ground), surface_diagonal, at.diagonal);
    }

    // Flow (7, 8). Eight pipes have the widths that make them isotropic.
    float l = push.cell_size;
    axis = accelerate(axis, ground, surface, ground_axis, surface_axis, steepest, l, PIPES == 8u ? 2.0 / 3.0 * l : l);
    if (PIPES == 8u) {
        diagonal = accelerate(diagonal, ground, surface, ground_diagonal, surface_diagonal, steepest, SQRT2 * l, SQRT2 / 6.0 * l);
    }
    axis = mix(vec4(0.0), axis, OPEN ? bvec4(true) : at.axis);
    diagonal = mix(vec4(0.0), diagonal, OPEN ? bvec4(true) : at.diagonal);

    // No cell gives more than it has (9).
    float outflow = sum(axis, diagonal);
    float available = depth * (l * l / push.time_step);
    float share = outflow > available ? available / outflow : 1.0;
    imageStore(axis_out, cell, axis * share);
    if (PIPES == 8u) imageStore(diagonal_out, cell, diagonal * share);
    imageStore(sediment_out, cell, vec4(sediment));

    float steepness = 0.0;
    if (CENTRAL_SLOPE) {
        steepness = gradient(AXIS(height, at), l);
    } else {
        precise vec4 fall_axis = axis * (surface - surface_axis);
        precise vec4 fall_diagonal = diagonal * (surface - surface_diagonal) * (1.0 / SQRT2);
        precise float fall = sum(fall_axis, fall_diagonal);
        steepness = outflow > 0.0 ? max(0.0, fall) / (l * outflow) : 0.0;
    }
    imageStore(slope, cell, vec4(steepness));
}
