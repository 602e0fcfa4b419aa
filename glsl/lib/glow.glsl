// The ground at a sample of the coarse grid, and the radiance that leaves it. The includer declares `wetness`, `reef` and `openness`.
#ifndef GLOW_GLSL
#define GLOW_GLSL

Place coarse_place(ivec2 at) {
    vec2 xz = coarse_position(at);
    Place place;
    place.point = vec3(xz.x, height_at(ground_cell(at)), xz.y);
    place.slope = height_slope(xz);
    place.wetness = imageLoad(wetness, ground_cell(at)).x;
    place.reef = imageLoad(reef, ground_cell(at)).x;
    place.openness = imageLoad(openness, at).x;
    place.footprint = coarse_cell_size();
    return place;
}

// `shade` is what shadow.comp found there.
vec3 glow_of(Ground found, Place place, vec2 shade) {
    vec3 light = frame.sun_irradiance * max(dot(found.normal, frame.sun_direction), 0.0)
               * sun_visibility(place.point.y, shade, coarse_cell_size(), coarse_cell_size())
               + sky_irradiance(found.normal) * place.openness + bounced(found.albedo, place.openness);
    return found.albedo / PI * light;
}

#endif
