// Where carbon is held fast: the open ocean and the rim of the grid never run out of it. On land the image holds LAND, which
// is 0 to a reader that takes max(0, …) and tells a neighbour that there is no water.
#ifndef CARBON_GLSL
#define CARBON_GLSL

const float LAND = -1.0;

float held(float carbon, float depth, bool rim, float ocean_carbon, float ocean_depth) {
    if (depth <= 0.0) return LAND;
    return rim || depth > ocean_depth ? ocean_carbon : carbon;
}

#endif
