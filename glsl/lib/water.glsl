// Sea water.
#ifndef WATER_GLSL
#define WATER_GLSL

const float REFRACTIVE_INDEX = 1.34;
const float FOAM = 0.75;   // reflectance

#endif
