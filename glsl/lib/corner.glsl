// The land as a mesh that other programs can draw: a colour and a normal at each corner of its triangles, and what lies
// evenly between them. The includer declares the images of the ground, and includes what `lib/surface.glsl` needs.
#ifndef CORNER_GLSL
#define CORNER_GLSL

struct Corner {
    vec3 point;
    vec3 normal;
    vec3 albedo;
};

// Without what is finer than any sample: textures show their mean.
Corner corner_at(vec3 point) {
    Stencil s = stencil(point.xz, frame.cells);
    Place place;
    place.point = point;
    place.slope = height_slope(point.xz);
    place.wetness = BILINEAR(wetness, s).x;
    place.reef = BILINEAR(reef, s).x;
    place.openness = BILINEAR(openness, stencil(point.xz, imageSize(openness).x)).x;
    place.footprint = 1e6;
    return Corner(point, normal_from_slope(place.slope), ground(place).albedo);
}

#endif
