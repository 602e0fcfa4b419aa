// Radiance of what stands on the ground. The includer declares the images of light, `materials`, `casts` and `cast_maps`; what it includes
// stands before.
#ifndef FOLIAGE_GLSL
#define FOLIAGE_GLSL

// Whether there are maps of the shadows that plants cast; an includer that has none says so.
#ifndef WITH_CASTS
#define WITH_CASTS true
#endif

// What the sun and the sky send to both sides of a surface.
struct Arriving {
    vec3 sun;          // on a plane that faces it
    float sky;         // share of the sky that is seen
    vec3 below;        // radiance of the ground below
    float hidden;      // share of the sky that other leaves hide
};

// Light from above and below on a plane with this normal.
vec3 dome(Arriving light, vec3 normal) {
    return light.sky * sky_irradiance(normal) + light.below * PI * 0.5 * (1.0 - normal.y);
}

vec3 leaving(Material material, Coat coat, Arriving light, vec3 normal, vec3 view, float footprint) {
    // The normal on the eye's side.
    vec3 n = dot(normal, view) > 0.0 ? -normal : normal;
    float facing = dot(n, frame.sun_direction);
    float mirrored = rough_schlick(material, dot(n, -view));
    vec3 scattered = coat.reflectance / PI * (light.sun * max(facing, 0.0) + dome(light, n))
                   + coat.transmittance / PI * (light.sun * max(-facing, 0.0) + dome(light, -n));
    // Leaves that hide the sky are lit themselves, half of them well, and are of the same colour.
    vec3 albedo = coat.reflectance + coat.transmittance;
    vec3 open_light = frame.sun_irradiance * max(frame.sun_direction.y, 0.0) + sky_irradiance(vec3(0.0, 1.0, 0.0));
    scattered += light.hidden * 0.25 * albedo * albedo / PI * open_light;
    vec3 gloss = light.sun * highlight(material, n, -view, frame.sun_direction, footprint) + mirrored * dome(light, n) / PI;
    return (1.0 - mirrored) * scattered + gloss;
}

// Of a plant that the eye sees over the distance `path` along `view`; `found` is what plant.frag says of it. `turn` differs from sample to
// sample.
vec3 plant_radiance(uvec4 found, vec3 view, float path, float turn) {
    vec3 point = frame.eye + path * view;
    float footprint = path * frame.sample_angle;
    Material material = materials[found.x];
    Coat coat = coat(material, point, found.y, footprint);
    Stencil coarse = stencil(point.xz, push.coarse_cells);
    Arriving light;
    vec4 leaves = BILINEAR(canopy, stencil(point.xz, imageSize(canopy).x));
    float visible = sun_visibility(point.y, BILINEAR(shadow, coarse).xy, coarse_cell_size(), footprint);
    if (visible > 0.0) {
        float elsewhere = through_canopy(leaves, point.y, 1.0 / max(frame.sun_direction.y, 0.1));
        visible *= WITH_CASTS ? cast_visibility(point, 0.02 + footprint, 6, turn, elsewhere) : elsewhere;
    }
    // Own leaves are among those of the canopy: what hides more counts.
    vec2 open = unpackUnorm2x16(found.w);
    light.sun = frame.sun_irradiance * visible;
    light.sky = BILINEAR(openness, coarse).x * min(open.x, through_canopy(leaves, point.y, MEAN_PATH));
    light.below = BILINEAR(glow, coarse).rgb * open.y * through_canopy(leaves, -1e9, MEAN_PATH);
    light.hidden = 1.0 - light.sky;
    vec3 normal = unpack_direction(found.z);
    coat.reflectance *= furrow(material, point, footprint, normal);
    return leaving(material, coat, light, normal, view, footprint);
}

#endif
