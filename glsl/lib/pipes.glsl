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

// Outflows of the three cells of a row.
struct Outflow {
    vec4 axis, axis_west, axis_east, diagonal, diagonal_west, diagonal_east;
};

#define OUTFLOW(axis_image, diagonal_image, at) \
    Outflow(imageLoad(axis_image, at.middle), imageLoad(axis_image, at.west), imageLoad(axis_image, at.east), \
            PIPES == 8u ? imageLoad(diagonal_image, at.middle) : vec4(0.0), \
            PIPES == 8u ? imageLoad(diagonal_image, at.west) : vec4(0.0), \
            PIPES == 8u ? imageLoad(diagonal_image, at.east) : vec4(0.0))

// The flux that enters a cell from each neighbour; none from off the grid.
vec4 axis_inflow(Outflow north, Outflow own, Outflow south, bvec4 inside) {
    return mix(vec4(0.0), vec4(own.axis_west.y, own.axis_east.x, north.axis.w, south.axis.z), inside);
}

vec4 diagonal_inflow(Outflow north, Outflow own, Outflow south, bvec4 inside) {
    vec4 inflow = vec4(north.diagonal_west.w, north.diagonal_east.z, south.diagonal_west.y, south.diagonal_east.x);
    return mix(vec4(0.0), inflow, inside);
}

// Depth after the rain (Korošec & Lebar Bajec (6)); the sea stays full.
float rained(float depth, float ground, float rain, float sea_level) {
    return ground < sea_level ? sea_level - ground : depth + rain;
}

#endif
