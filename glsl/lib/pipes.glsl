// What the two halves of a hydraulic iteration share: the virtual pipes of Mei, Decaudin & Hu 2007 from each cell to its four
// or eight neighbours. Pipe L of a cell carries its outflow to L; what flows in from there is pipe R of the cell L.
#ifndef PIPES_GLSL
#define PIPES_GLSL

#include "lib/grid.glsl"

layout(constant_id = 0) const uint PIPES = 8; // or 4
layout(constant_id = 1) const bool CONTROLS = false;

// The flux that enters from each neighbour; none from off the grid.
#define AXIS_INFLOW(image, at) \
    mix(vec4(0.0), \
        vec4(imageLoad(image, at.L).y, imageLoad(image, at.R).x, imageLoad(image, at.T).w, imageLoad(image, at.B).z), \
        at.axis)
#define DIAGONAL_INFLOW(image, at) \
    mix(vec4(0.0), \
        vec4(imageLoad(image, at.TL).w, imageLoad(image, at.TR).z, imageLoad(image, at.BL).y, \
             imageLoad(image, at.BR).x), \
        at.diagonal)

// Depth after the rain (Korošec & Lebar Bajec (6)); the sea stays full.
float rained(float depth, float ground, float rain, float sea_level) {
    return ground < sea_level ? sea_level - ground : depth + rain;
}

#endif
