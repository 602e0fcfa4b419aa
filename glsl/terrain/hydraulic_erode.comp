#version 460
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// Second half of an iteration of hydraulic erosion: sediment and bed diffuse, water moves, the ground wears or fills, water
// evaporates (Korošec & Lebar Bajec (10–16, 18, 19); deposition with its sign mended).

#include "lib/pipes.glsl"

layout(local_size_x = 64, local_size_y = 1) in;
// Whether the bed creeps or rivers wear their banks.
layout(constant_id = 4) const bool BED_DIFFUSION = true;

layout(binding = 0, r32f) uniform readonly image2D height_in;
layout(binding = 1, r32f) uniform writeonly image2D height_out;
layout(binding = 2, r32f) uniform readonly image2D start;
layout(binding = 3, r32f) uniform image2D change;
layout(binding = 4, rgba32f) uniform readonly image2D water_in; // as water_out
layout(binding = 5, rgba32f) uniform writeonly image2D water_out; // depth; sediment per unit of flux and discharge, or velocity; wetness
layout(binding = 6, r32f) uniform readonly image2D sediment_in;
layout(binding = 7, r32f) uniform writeonly image2D sediment_out;
layout(binding = 8, rgba32f) uniform readonly image2D axis;
layout(binding = 9, rgba32f) uniform readonly image2D diagonal;
layout(binding = 10, r32f) uniform readonly image2D slope;
layout(binding = 11, rgba32f) uniform readonly image2D controls;
layout(push_constant, scalar) uniform Push {
    float cell_size;
    float time_step;
    float sea_level;
    float rain;
    float sediment_mixing; // with each neighbour
    float creep_mixing;
    float bank_mixing;     // per unit of discharge on a face
    float max_speed;
    float capacity;
    float min_slope;
    float ramp_start;
    float ramp;            // per metre of depth
    float sea_fade;        // per metre of depth
    float erosion;         // share in one step
    float deposition;
    float max_change;      // in one step
    float evaporation;     // share in one step
    float wet_depth;
    float wet_memory;
} push;

const float DRY = 1e-6;
const float LARGEST_MIXING = 0.2;

void main() {
    ivec2 first = first_cell();
    ivec2 size = imageSize(height_in);
    if (outside(first, size)) return;

    float height[ROWS + 2][COLUMNS + 2];
    float depths[ROWS + 2][COLUMNS + 2];
    float discharge[ROWS + 2][COLUMNS + 2];
    float suspension[ROWS + 2][COLUMNS + 2];
    float masks[ROWS + 2][COLUMNS + 2];
    vec4 outflow_axis[ROWS + 2][COLUMNS + 2];
    vec4 outflow_diagonal[ROWS + 2][COLUMNS + 2];
    EACH_WITH_RIM(1, j, i) {
        ivec2 at = clamp(first + ivec2(i, j) - 1, ivec2(0), size - 1);
        vec4 water = imageLoad(water_in, at);
        precise float squared = water.y * water.y + water.z * water.z;
        height[j][i] = imageLoad(height_in, at).x;
        depths[j][i] = water.x;
        discharge[j][i] = SEMI_LAGRANGIAN ? sqrt(squared) * water.x : water.z;
        suspension[j][i] = imageLoad(sediment_in, at).x;
        masks[j][i] = CONTROLS ? imageLoad(controls, at).z : 1.0;
        outflow_axis[j][i] = imageLoad(axis, at);
        outflow_diagonal[j][i] = PIPES == 8u ? imageLoad(diagonal, at) : vec4(0.0);
    }

    EACH_OWN(j, i) {
        ivec2 cell = first + ivec2(i, j) - 1;
        ivec2 own = min(cell, size - 1); // for loads: the last blocks may reach beyond the grid
        Stencil at = stencil(cell, size);
        float ground = height[j][i];
        float wetness = imageLoad(water_in, own).w;
        vec2 control = CONTROLS ? imageLoad(controls, own).xy : vec2(1.0);
        float mask = masks[j][i];
        bool sea = ground < push.sea_level;
        float depth = rained(depths[j][i], ground, push.rain * control.x, push.sea_level);

        // Suspended sediment diffuses between wet cells (18, as a conservative exchange).
        float sediment = suspension[j][i];
        bvec4 wet = greaterThan(min(vec4(depths[j][i]), AXIS_OF(depths, j, i)), vec4(DRY));
        precise vec4 rise = AXIS_OF(suspension, j, i) - sediment;
        precise float diffused = sediment + push.sediment_mixing * sum(mix(vec4(0.0), rise, wet));

        // The bed creeps, and rivers wear their banks.
        vec4 beside = AXIS_OF(height, j, i);
        precise float crept = imageLoad(change, own).x;
        if (BED_DIFFUSION) {
            vec4 discharge_axis = discharge[j][i] + AXIS_OF(discharge, j, i);
            vec4 mixing = min(vec4(LARGEST_MIXING), push.creep_mixing + push.bank_mixing * discharge_axis)
                * min(vec4(mask), AXIS_OF(masks, j, i));
            precise vec4 slide = mixing * (beside - ground);
            crept += sum(slide);
        }

        // Depth (10).
        vec4 out_axis = outflow_axis[j][i];
        vec4 out_diagonal = outflow_diagonal[j][i];
        vec4 in_axis = AXIS_INFLOW(outflow_axis, j, i, at.axis);
        vec4 in_diagonal = DIAGONAL_INFLOW(outflow_diagonal, j, i, at.diagonal);
        float area = push.cell_size * push.cell_size;
        precise float gained = sum(in_axis, in_diagonal) - sum(out_axis, out_diagonal);
        precise float flowed = max(0.0, depth + push.time_step / area * gained);
        flowed = sea ? depth : flowed;

        // Velocity (13, 14): the discharge through the middle of the cell over the mean depth.
        precise vec4 net = out_axis - in_axis;
        precise vec4 net_diagonal = out_diagonal - in_diagonal;
        precise float east = (net.y - net.x) + ((net_diagonal.y + net_diagonal.w) - (net_diagonal.x + net_diagonal.z));
        precise float south = (net.w - net.z) + ((net_diagonal.z + net_diagonal.w) - (net_diagonal.x + net_diagonal.y));
        precise float both = depth + flowed;
        float per_speed = both > 2.0 * DRY ? 1.0 / (push.cell_size * both) : 0.0;
        precise float squared = east * east + south * south;
        float speed = min(sqrt(squared) * per_speed, push.max_speed);
        float mean_depth = 0.5 * both;

        // Capacity (11, 12), with a ramp over the depth; rivers lose it in the sea.
        float steepness = OUTFLOW_SLOPE ? imageLoad(slope, own).x : gradient(beside, push.cell_size);
        float sine = max(push.min_slope, steepness / sqrt(1.0 + steepness * steepness));
        float ramp = clamp((mean_depth - push.ramp_start) * push.ramp, 0.0, 1.0);
        float fade = sea ? clamp(1.0 - (push.sea_level - ground) * push.sea_fade, 0.0, 1.0) : 1.0;
        float capacity = push.capacity * speed * sine * ramp * fade;

        // Wear or fill (15, 16), but neither below all neighbours nor above them: no constants dig a hole or pile a tower.
        // Only what left the ground arrives in the water, to the last bit that e can hold.
        float lack = capacity - diffused;
        float taken = lack > 0.0 ? push.erosion * control.y * lack : push.deposition * lack;
        taken = clamp(taken * mask, -push.max_change, push.max_change);
        vec4 across = DIAGONAL_OF(height, j, i);
        float before = imageLoad(start, own).x + crept;
        float most = max(0.0, before - min(ground, min4(min(beside, across))));
        float least = min(0.0, before - max(ground, max4(max(beside, across))));
        taken = clamp(taken, least, most);
        precise float e = crept - taken;
        precise float left_ground = diffused + (crept - e);
        float suspended = some(left_ground);
        precise float worn = imageLoad(start, own).x + e;

        // Evaporation (19); the sea stays full.
        precise float dried = flowed - flowed * push.evaporation;
        float left = worn < push.sea_level ? push.sea_level - worn : dried;
        wetness = clamp(wetness + (left > push.wet_depth ? push.time_step : -push.time_step), 0.0, push.wet_memory);
        float per_flux = depth > DRY ? push.time_step / (area * depth) * suspended : 0.0;
        vec2 flow = vec2(per_flux, speed * mean_depth);
        if (SEMI_LAGRANGIAN) {
            float slowed = squared > 0.0 ? speed * inversesqrt(squared) : 0.0;
            flow = vec2(east * slowed, south * slowed);
        }
        if (!outside(cell, size)) {
            imageStore(change, cell, vec4(e));
            imageStore(height_out, cell, vec4(worn));
            imageStore(sediment_out, cell, vec4(suspended));
            imageStore(water_out, cell, vec4(left, flow, wetness));
        }
    }
}
