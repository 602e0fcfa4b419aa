// What the two halves of a hydraulic iteration share: the virtual pipes of Mei, Decaudin & Hu 2007 from each cell to its four
// or eight neighbours. Pipe L of a cell carries its outflow to L; what flows in from there is pipe R of the cell L.
#ifndef PIPES_GLSL
#define PIPES_GLSL

#include "lib/block.glsl"

layout(constant_id = 0) const uint PIPES = 8; // or 4
layout(constant_id = 1) const bool CONTROLS = false;
// The slope in the capacity: the drop of the water surface weighted by the outflow, or of the ground by central differences.
layout(constant_id = 2) const bool OUTFLOW_SLOPE = true;
// Sediment leaves with the water, or is traced back along the velocity.
layout(constant_id = 3) const bool SEMI_LAGRANGIAN = false;

// The flux that enters a cell from each neighbour, from arrays of outflows; none from off the grid.
#define AXIS_INFLOW(outflow, j, i, inside) \
    mix(vec4(0.0), \
        vec4(outflow[j][i - 1].y, outflow[j][i + 1].x, outflow[j - 1][i].w, outflow[j + 1][i].z), \
        inside)
#define DIAGONAL_INFLOW(outflow, j, i, inside) \
    mix(vec4(0.0), \
        vec4(outflow[j - 1][i - 1].w, outflow[j - 1][i + 1].z, outflow[j + 1][i - 1].y, outflow[j + 1][i + 1].x), \
        inside)

// Sediment (m) and fluxes (m³/s) below this are none. What loses a share of itself in each step would end as a denormal number,
// and with those a CPU takes twice the time.
const float NOTHING = 1e-12;

float some(float x) {
    return abs(x) < NOTHING ? 0.0 : x;
}

vec4 some(vec4 x) {
    return mix(x, vec4(0.0), lessThan(abs(x), vec4(NOTHING)));
}

// Depth after the rain (Korošec & Lebar Bajec (6)); the sea stays full.
float rained(float depth, float ground, float rain, float sea_level) {
    return ground < sea_level ? sea_level - ground : depth + rain;
}

#endif
