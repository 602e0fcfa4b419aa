#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Radiance of every sample, as shade.comp finds it, but swiftly: the ground's colour and relief are those of the coarse grid (coat.comp),
// the sea has no waves that are seen and mirrors the sky alone, clouds are coarse and far beyond all else, and no plant casts a shadow of its
// own. Each program shades one kind of thing.

#include "lib/frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 1, r32f) uniform readonly image2D range;
layout(binding = 2, rgba32f) uniform writeonly image2D radiance;
layout(binding = 3, r32f) uniform readonly image2D height;
layout(binding = 4, r32f) uniform readonly image2D water;
layout(binding = 5, r32f) uniform readonly image2D openness;
layout(binding = 6, rg32f) uniform readonly image2D shadow;
layout(binding = 7, rgba32f) uniform readonly image2D coat;
layout(binding = 8, rg32f) uniform readonly image2D relief;
layout(binding = 9, rgba32f) uniform readonly image2D canopy;

layout(push_constant, scalar) uniform Push {
    int coarse_cells;  // side of the grid of openness, shadow, coat and relief
    uint first_tile;   // of the list of tiles
} push;

float coarse_cell_size() {
    return frame.extent / float(push.coarse_cells - 1);
}

#include "lib/own_part.glsl"
#include "lib/heightfield.glsl"
#include "lib/fields.glsl"
#include "lib/texture.glsl"
#include "lib/sky.glsl"
#include "lib/air.glsl"
#include "lib/light.glsl"
#include "lib/sea.glsl"
// Clouds without their finest puffs.
#define CLOUD_FOOTPRINT 3.0
#include "lib/clouds.glsl"
#include "lib/canopy.glsl"
#include "lib/wet.glsl"

vec3 ground_radiance(vec3 point, vec3 view, float footprint) {
    Stencil coarse = stencil(point.xz, push.coarse_cells);
    vec3 albedo = BILINEAR(coat, coarse).rgb;
    vec3 normal = normal_from_slope(height_slope(point.xz) + BILINEAR(relief, coarse).xy);
    float open = BILINEAR(openness, coarse).x;
    vec3 sun = frame.sun_irradiance * sun_visibility(point.y, BILINEAR(shadow, coarse).xy, coarse_cell_size(),
                                                     0.3 * frame.cell_size + footprint);
    float depth = frame.sea_level - point.y;
    if (depth > 0.0) return drowned(albedo, normal, sun, open, depth);
    float through = 1.0;
    if (imageSize(canopy).x > 1) {
        vec4 leaves = BILINEAR(canopy, stencil(point.xz, imageSize(canopy).x));
        through = through_canopy(leaves, point.y, MEAN_PATH);
        sun *= through_canopy(leaves, point.y, 1.0 / max(frame.sun_direction.y, 0.1));
    }
    vec3 light = sun * max(dot(normal, frame.sun_direction), 0.0)
               + (sky_irradiance(normal) * open + bounced(albedo, open)) * through;
    vec3 bed = albedo / PI * light;
    // Rivers and lakes mirror the sky, whichever part of it.
    float depth_of_river = BILINEAR(water, stencil(point.xz, frame.cells)).x;
    vec3 mirrored = mix(bed, sky_irradiance(vec3(0.0, 1.0, 0.0)) / PI, open * open * through);
    vec3 river = mix(bed * exp(-2.0 * frame.attenuation * depth_of_river) * 0.7, mirrored, fresnel(clamp(-view.y, 0.0, 1.0)));
    return mix(bed, river, smoothstep(0.08, 0.6, depth_of_river));
}

// The bottom below where a ray enters the sea, as steep as it may be.
vec3 bottom_of(vec3 surface, vec3 along, out float path) {
    path = 0.0;
    for (int index = 0; index < 3; ++index) {
        vec3 at = surface + path * along;
        path += 0.8 * (at.y - height_bilinear(at.xz)) / -along.y;
    }
    path = max(path, 0.0);
    return surface + path * along;
}

vec3 sea_radiance(vec3 surface, vec3 view, float footprint) {
    float path;
    vec3 bottom = bottom_of(surface, refract(view, vec3(0.0, 1.0, 0.0), 1.0 / REFRACTIVE_INDEX), path);
    Stencil s = stencil(surface.xz, push.coarse_cells);
    Ripples waves = Ripples(vec2(0.0), frame.roughness);
    const vec3 normal = vec3(0.0, 1.0, 0.0);
    float mirrored = mean_fresnel(max(dot(normal, -view), 0.02), waves.deviation);
    float visible = sun_visibility(frame.sea_level, BILINEAR(shadow, s).xy, coarse_cell_size(),
                                   0.3 * frame.cell_size + footprint);
    // Waves that face the eye are seen most, so at a glancing angle the mirror shows the sky higher up.
    vec3 mirror = reflect(view, normal);
    mirror.y = max(mirror.y, 0.0);
    mirror.y += 1.5 * waves.deviation * exp(-mirror.y / (waves.deviation + 1e-3));
    vec3 reflection = sky_radiance(normalize(mirror));
    vec3 open_light = frame.sun_irradiance * max(frame.sun_direction.y, 0.0) * visible
                    + sky_irradiance(vec3(0.0, 1.0, 0.0)) * 0.5 * (1.0 + BILINEAR(openness, s).x);
    vec3 transmittance = exp(-frame.attenuation * path);
    float down = max(frame.sea_level - bottom.y, 0.0);
    vec3 body = ground_radiance(bottom, view, footprint) * transmittance / (REFRACTIVE_INDEX * REFRACTIVE_INDEX)
              + frame.deep_colour / PI * open_light * (1.0 - transmittance * exp(-1.1 * frame.attenuation * down));
    vec3 seen = (1.0 - mirrored) * body + mirrored * reflection + glitter(view, waves) * visible;
    return mix(seen, FOAM / PI * open_light, BILINEAR(coat, s).a);
}

void main() {
    ivec2 at = own_sample();
    if (any(greaterThanEqual(at, imageSize(range)))) return;
    vec3 view = camera_ray(vec2(at) + 0.5);
    float path;
    if (part_of(view, imageLoad(range, at).x, path) != PART) return;
    vec3 surface = frame.eye + path * view;
    float footprint = path * frame.sample_angle;
    vec3 light;
    if (PART == SEA) {
        light = veil(sea_radiance(surface, view, footprint * inversesqrt(max(-view.y, 0.02))), view, path);
    } else if (PART == GROUND) {
        light = veil(ground_radiance(surface, view, footprint), view, path);
    } else {
        light = sky_radiance(view) + sun_disc_radiance(view);
        if (PART == CLOUDY) light = with_clouds(light, view, 1e9);
    }
    imageStore(radiance, at, vec4(light, 1.0));
}
