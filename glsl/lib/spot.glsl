// Places on surfaces: how they turn a path.
#ifndef SPOT_GLSL
#define SPOT_GLSL

// A place on a surface that a path has come to, in the air or under water.
struct Spot {
    vec3 point;
    vec3 outward;    // geometric normal, on the path's side
    vec3 normal;     // of shading
    Bsdf bsdf;
    vec3 emission;
    vec3 albedo;
    uint object;
};

// Whether light from `l` comes from the same side of the surface as of its shading normal; if not there is none, lest it shine
// through. Constant materials know the shading normal alone, as those of other renderers do.
bool on_one_side(Spot spot, float facing, vec3 l) {
    return push.work.plain == 1u || (facing > 0.0) == (dot(l, spot.outward) > 0.0);
}

// Value times cosine towards the path, for light from the world direction `l`.
vec3 leaving(Spot spot, vec3 view, vec3 l, out float density) {
    mat3 axes = frame_of(spot.normal);
    density = 0.0;
    vec3 local = l * axes;
    if (local.z == 0.0 || !on_one_side(spot, local.z, l)) return vec3(0.0);
    vec3 v = -view * axes;
    v.z = max(v.z, 1e-3);
    return scattered(spot.bsdf, normalize(v), local, density);
}

// How often to look for the sky rather than for the sun here.
float sky_share(Spot spot) {
    float sky = frame.sky == SKY_NONE ? 0.0 : luminance(sky_irradiance(vec3(0.0, 1.0, 0.0)));
    if (!has_sun()) return 1.0;
    float facing = dot(spot.normal, frame.sun_direction);
    float reflected = luminance(spot.bsdf.reflectance);
    float transmitted = luminance(spot.bsdf.transmittance);
    float sun = luminance(frame.sun_irradiance) * (facing > 0.0 ? facing * reflected : -facing * transmitted);
    if (spot.bsdf.refractive_index > 1.0 && facing > 0.0) sun += 0.05 * luminance(frame.sun_irradiance);
    sky *= 0.5 * (reflected + transmitted) + 0.02;
    return sky + sun > 0.0 ? sky / (sky + sun) : 1.0;
}

// Gathers what the place sends out and looks for light; then the path goes on.
void turn_at(uint index, Path path, Spot spot, float range) {
    vec3 view = path.direction;
    if (push.work.turn == 0u) features[index] = Feature(spot.albedo, spot.normal, spot.point, range, spot.object);
    path.radiance += path.throughput * spot.emission;
    paths[index].radiance = path.radiance;
    if (push.work.turn >= push.work.bounces) return;
    path.sky_share = sky_share(spot);
    Light light = find_light(index, path, spot.point.y);
    float scattering;
    vec3 value = leaving(spot, view, light.direction, scattering);
    look(index, path, start(spot.point, spot.outward, light.direction), light, value, scattering);

    mat3 axes = frame_of(spot.normal);
    vec3 v = -view * axes;
    v.z = max(v.z, 1e-3);
    Scattered way = scatter(spot.bsdf, normalize(v), random_pair(index, 1u), random_pair(index, 2u).x);
    vec3 direction = axes * way.direction;
    if (way.density <= 0.0 || !on_one_side(spot, way.direction.z, direction)) return;
    path.origin = start(spot.point, spot.outward, direction);
    path.direction = direction;
    path.throughput *= way.weight;
    path.density = way.density;
    path.spread = 0.3;
    go_on(index, path);
}

#endif
