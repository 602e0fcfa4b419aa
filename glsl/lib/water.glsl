// Sea water.
#ifndef WATER_GLSL
#define WATER_GLSL

const float REFRACTIVE_INDEX = 1.34;

#endif
