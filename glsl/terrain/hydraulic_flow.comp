#version 460
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// First half of an iteration of hydraulic erosion: sediment travels with the last fluxes, it rains, and the virtual pipes
// accelerate (Mei, Decaudin & Hu 2007; Korošec & Lebar Bajec (6–9, 17)).

#include "lib/pipes.glsl"

layout(local_size_x = 64, local_size_y = 1) in;
// Outside an open rim lies dry ground at the rim's own height.
layout(constant_id = 4) const bool OPEN = false;
// Cross-section of a pipe per width: the whole pipe depth, or as much of it as the flow fills.
layout(constant_id = 5) const bool FIXED_SECTION = false;
layout(constant_id = 6) const bool DRAG = true;

layout(binding = 0, r32f) uniform readonly image2D height;
layout(binding = 1, rgba32f) uniform readonly image2D water; // depth; sediment per unit of flux, or velocity
layout(binding = 2, r32f) uniform readonly image2D sediment_in;
layout(binding = 3, r32f) uniform writeonly image2D sediment_out;
layout(binding = 4, rgba32f) uniform readonly image2D axis_in;
layout(binding = 5, rgba32f) uniform writeonly image2D axis_out;
layout(binding = 6, rgba32f) uniform readonly image2D diagonal_in;
layout(binding = 7, rgba32f) uniform writeonly image2D diagonal_out;
layout(binding = 8, r32f) uniform writeonly image2D slope;
layout(binding = 9, rgba32f) uniform readonly image2D controls;
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

// Sediment a time step ago where the water of a cell comes from (17): at most one cell away, so that the bilinear sample is
// a weighted mean of the neighbourhood.
float traced_back(vec2 velocity, float own, vec4 axis, vec4 diagonal) {
    precise vec2 back = -velocity * push.time_step / push.cell_size;
    vec2 before = max(-back, vec2(0.0));
    vec2 after = max(back, vec2(0.0));
    vec2 stay = 1.0 - abs(back);
    vec4 weight_axis = vec4(before.x * stay.y, after.x * stay.y, stay.x * before.y, stay.x * after.y);
    vec4 weight_diagonal = vec4(before.x * before.y, after.x * before.y, before.x * after.y, after.x * after.y);
    precise float moved = stay.x * stay.y * own + sum(weight_axis * axis, weight_diagonal * diagonal);
    return moved;
}

void main() {
    ivec2 first = first_cell();
    ivec2 size = imageSize(height);
    if (outside(first, size)) return;

    float ground[ROWS + 2][COLUMNS + 2];
    float depth[ROWS + 2][COLUMNS + 2];   // after the rain (6)
    float surface[ROWS + 2][COLUMNS + 2];
    float suspended[ROWS + 2][COLUMNS + 2];
    vec2 velocity[ROWS + 2][COLUMNS + 2];
    float per_flux[ROWS + 2][COLUMNS + 2];
    vec4 last_axis[ROWS + 2][COLUMNS + 2];
    vec4 last_diagonal[ROWS + 2][COLUMNS + 2];
    EACH_WITH_RIM(1, j, i) {
        ivec2 at = clamp(first + ivec2(i, j) - 1, ivec2(0), size - 1);
        vec4 wet = imageLoad(water, at);
        float rain = CONTROLS ? push.rain * imageLoad(controls, at).x : push.rain;
        float h = imageLoad(height, at).x;
        ground[j][i] = h;
        depth[j][i] = rained(wet.x, h, rain, push.sea_level);
        surface[j][i] = h < push.sea_level ? push.sea_level : h + depth[j][i];
        velocity[j][i] = wet.yz;
        per_flux[j][i] = wet.y;
        suspended[j][i] = imageLoad(sediment_in, at).x;
        last_axis[j][i] = imageLoad(axis_in, at);
        last_diagonal[j][i] = PIPES == 8u ? imageLoad(diagonal_in, at) : vec4(0.0);
    }

    EACH_OWN(j, i) {
        ivec2 cell = first + ivec2(i, j) - 1;
        Stencil at = stencil(cell, size);

        // Transport (17).
        float sediment = suspended[j][i];
        if (SEMI_LAGRANGIAN) {
            sediment = traced_back(velocity[j][i], sediment, AXIS_OF(suspended, j, i), DIAGONAL_OF(suspended, j, i));
        } else {
            vec4 into_axis = AXIS_INFLOW(last_axis, j, i, at.axis) * AXIS_OF(per_flux, j, i);
            vec4 into_diagonal = DIAGONAL_INFLOW(last_diagonal, j, i, at.diagonal) * DIAGONAL_OF(per_flux, j, i);
            float outflow = sum(last_axis[j][i], last_diagonal[j][i]);
            precise float carried =
                max(0.0, sediment - per_flux[j][i] * outflow) + sum(into_axis, into_diagonal);
            sediment = carried;
        }

        float own_ground = ground[j][i];
        float own_surface = surface[j][i];
        vec4 ground_axis = AXIS_OF(ground, j, i);
        vec4 ground_diagonal = DIAGONAL_OF(ground, j, i);
        vec4 surface_axis = AXIS_OF(surface, j, i);
        vec4 surface_diagonal = DIAGONAL_OF(surface, j, i);
        float steepest = DRAG ? gradient(surface_axis, push.cell_size) : 0.0;
        if (OPEN) {
            ground_axis = mix(vec4(own_ground), ground_axis, at.axis);
            ground_diagonal = mix(vec4(own_ground), ground_diagonal, at.diagonal);
            surface_axis = mix(vec4(own_ground), surface_axis, at.axis);
            surface_diagonal = mix(vec4(own_ground), surface_diagonal, at.diagonal);
        }

        // Flow (7, 8). Eight pipes have the widths that make them isotropic.
        float l = push.cell_size;
        vec4 axis = accelerate(last_axis[j][i], own_ground, own_surface, ground_axis, surface_axis, steepest, l,
                               PIPES == 8u ? 2.0 / 3.0 * l : l);
        axis = mix(vec4(0.0), axis, OPEN ? bvec4(true) : at.axis);
        vec4 diagonal = vec4(0.0);
        if (PIPES == 8u) {
            diagonal = accelerate(last_diagonal[j][i], own_ground, own_surface, ground_diagonal, surface_diagonal, steepest,
                                  SQRT2 * l, SQRT2 / 6.0 * l);
            diagonal = mix(vec4(0.0), diagonal, OPEN ? bvec4(true) : at.diagonal);
        }

        // No cell gives more than it has (9).
        float outflow = sum(axis, diagonal);
        float available = depth[j][i] * (l * l / push.time_step);
        float share = outflow > available ? available / outflow : 1.0;

        if (!outside(cell, size)) {
            imageStore(axis_out, cell, some(axis * share));
            if (PIPES == 8u) imageStore(diagonal_out, cell, some(diagonal * share));
            imageStore(sediment_out, cell, vec4(some(sediment)));
            if (OUTFLOW_SLOPE) {
                precise vec4 fall_axis = axis * (own_surface - surface_axis);
                precise vec4 fall_diagonal = diagonal * (own_surface - surface_diagonal) * (1.0 / SQRT2);
                precise float fall = sum(fall_axis, fall_diagonal);
                imageStore(slope, cell, vec4(outflow > 0.0 ? max(0.0, fall) / (l * outflow) : 0.0));
            }
        }
    }
}
