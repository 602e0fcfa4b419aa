#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Radiance of every sample: ground, sea or sky, whichever the ray meets first. The bottom of the sea is shaded as the
// ground is, by light that came through the water.

#include "lib/frame.glsl"
#include "lib/cast.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 1, r32f) uniform readonly image2D range;
layout(binding = 2, rgba32f) uniform writeonly image2D radiance;
layout(binding = 3, r32f) uniform readonly image2D height;
layout(binding = 4, r32f) uniform readonly image2D water;
layout(binding = 5, r32f) uniform readonly image2D wetness;
layout(binding = 6, r32f) uniform readonly image2D reef;
layout(binding = 7, r32f) uniform readonly image2D openness;
layout(binding = 8, r32f) uniform readonly image2D surf;
layout(binding = 9, rg32f) uniform readonly image2D shadow;
layout(binding = 10, rgba32f) uniform readonly image2D glow;
layout(binding = 11, scalar) readonly buffer Casts { Cast casts[]; };
layout(binding = 12, r32f) uniform readonly image2D cast_maps;
layout(binding = 13, rgba32f) uniform readonly image2D canopy;

layout(push_constant, scalar) uniform Push {
    ivec2 origin;      // of the tile, in samples of the whole picture
    int coarse_cells;  // side of the grid of openness, surf, shadow and glow
    int first;         // row of the tile's samples that the first invocations are of
} push;

float coarse_cell_size() {
    return frame.extent / float(push.coarse_cells - 1);
}

#include "lib/heightfield.glsl"
#include "lib/fields.glsl"
#include "lib/texture.glsl"
#include "lib/surface.glsl"
#include "lib/sky.glsl"
#include "lib/air.glsl"
#include "lib/light.glsl"
#include "lib/sea.glsl"
#include "lib/foam.glsl"
#include "lib/wet.glsl"
#include "lib/clouds.glsl"
#include "lib/canopy.glsl"
#include "lib/casts.glsl"

// A view ray's end on the ground, through air and perhaps water.
struct Hit {
    vec3 point;
    float footprint;
    float path;        // metres of water that the ray crossed
};

// Where a ray that enters the sea at `start` along `along` meets the bottom. Each step spends a share of the gap to
// the bottom below, so it closes in from above on any but a vertical wall.
Hit sea_bottom(vec3 start, vec3 along, float footprint) {
    float path = 0.0;
    for (int index = 0; index < 12; ++index) {
        vec3 at = start + path * along;
        float gap = at.y - height_bilinear(at.xz);
        if (abs(gap) < 0.02) break;
        path += 0.8 * gap / -along.y;
    }
    path = max(path, 0.0);
    vec3 at = start + path * along;
    // A reef's flat is not as flat as the grid knows it: pools of a metre lie between its heads.
    float pool = 1.4 * smoothstep(-0.1, 0.7, mottle(at.xz, 130.0, 6, 0.65, footprint, 401u).x)
               * smoothstep(0.4, 2.5, BILINEAR(reef, stencil(at.xz, frame.cells)).x);
    path += pool / -along.y;
    return Hit(start + path * along, footprint, path);
}

// The island in the mirror of the sea: (radiance, how much of the sky it hides). Waves blur it by `spread` radians.
vec4 mirrored_land(vec3 start, vec3 along, float spread) {
    vec4 seen = vec4(0.0);
    float distance_along = 1.5 * frame.cell_size;
    for (int index = 0; index < 28 && seen.a < 0.99; ++index) {
        vec3 at = start + distance_along * along;
        if (at.y > frame.top || outside(at.xz) > 0.0) break;
        float ground = height_at(ivec2(round(grid_position(at.xz))));
        float blur = 0.5 * frame.cell_size + spread * distance_along;
        float cover = smoothstep(-blur, blur, ground - at.y)
                    * smoothstep(frame.sea_level, frame.sea_level + 2.0, ground);
        ivec2 cell = ivec2(round((at.xz / frame.extent + 0.5) * float(push.coarse_cells - 1)));
        seen += (1.0 - seen.a) * cover * vec4(imageLoad(glow, cell).rgb, 1.0);
        distance_along *= 1.25;
    }
    return seen;
}

// Radiance that leaves the ground towards the eye. Under water, light arrives and bounces as the sea lets it.
vec3 ground_radiance(Hit hit, vec3 view, float turn) {
    Stencil s = stencil(hit.point.xz, frame.cells);
    Stencil coarse = stencil(hit.point.xz, push.coarse_cells);
    Place place;
    place.point = hit.point;
    place.slope = height_slope(hit.point.xz);
    place.wetness = BILINEAR(wetness, s).x;
    place.reef = BILINEAR(reef, s).x;
    place.openness = BILINEAR(openness, coarse).x;
    place.footprint = hit.footprint;
    Ground found = ground(place);

    float visible = sun_visibility(hit.point.y, BILINEAR(shadow, coarse).xy, coarse_cell_size(),
                                   0.3 * frame.cell_size + hit.footprint);
    vec3 sun = frame.sun_irradiance * visible;
    float depth = frame.sea_level - hit.point.y;
    if (depth <= 0.0) {
        vec4 leaves = BILINEAR(canopy, stencil(hit.point.xz, imageSize(canopy).x));
        if (visible > 0.0) {
            float elsewhere = through_canopy(leaves, hit.point.y, 1.0 / max(frame.sun_direction.y, 0.1));
            sun *= cast_visibility(hit.point, 0.0, 12, turn, elsewhere);
        }
        float through = through_canopy(leaves, hit.point.y, MEAN_PATH);
        vec3 light = sun * max(dot(found.normal, frame.sun_direction), 0.0)
                   + sky_irradiance(found.normal) * place.openness * through
                   + bounced(found.albedo, place.openness) * through;
        return wet(found.albedo / PI * light, view, BILINEAR(water, s).x, place.openness * through);
    }
    return drowned(found.albedo, found.normal, sun, place.openness, depth);
}

vec3 sea_radiance(vec3 surface, vec3 view, float footprint, Hit bottom, vec3 bottom_radiance) {
    Stencil s = stencil(surface.xz, push.coarse_cells);
    Ripples waves = ripples(surface.xz, footprint);
    vec3 normal = normal_from_slope(waves.slope);
    float cosine = max(dot(normal, -view), 0.02);
    float mirrored = mean_fresnel(cosine, waves.deviation);
    float visible = sun_visibility(frame.sea_level, BILINEAR(shadow, s).xy, coarse_cell_size(),
                                   0.3 * frame.cell_size + footprint);

    // Waves that face the eye are seen most, so at a glancing angle the mirror shows the sky higher up.
    vec3 mirror = reflect(view, normal);
    mirror.y = max(mirror.y, 0.0);
    mirror.y += 1.5 * waves.deviation * exp(-mirror.y / (waves.deviation + 1e-3));
    mirror = normalize(mirror);
    vec4 land = mirrored_land(surface, mirror, waves.deviation);
    vec3 reflection = (1.0 - land.a) * sky_radiance(mirror) + land.rgb;
    vec3 sparkle = glitter(view, waves) * visible;

    // Water between surface and bottom adds its own colour as it takes the bottom's.
    vec3 open_light = frame.sun_irradiance * max(frame.sun_direction.y, 0.0) * visible
                    + sky_irradiance(vec3(0.0, 1.0, 0.0)) * 0.5 * (1.0 + BILINEAR(openness, s).x);
    vec3 transmittance = exp(-frame.attenuation * bottom.path);
    float down = max(frame.sea_level - bottom.point.y, 0.0);
    vec3 round_trip = transmittance * exp(-1.1 * frame.attenuation * down);
    vec3 body = bottom_radiance * transmittance / (REFRACTIVE_INDEX * REFRACTIVE_INDEX)
              + frame.deep_colour / PI * open_light * (1.0 - round_trip);

    vec3 seen = (1.0 - mirrored) * body + mirrored * reflection + sparkle;
    float white = foam(surface.xz, down, BILINEAR(surf, s).x, footprint);
    return mix(seen, FOAM / PI * open_light, white);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, push.first);
    if (any(greaterThanEqual(at, imageSize(range)))) return;
    vec3 view = camera_ray(vec2(push.origin + at) + 0.5);
    // Negative is the range of what stands on the ground.
    float first_range = imageLoad(range, at).x;
    float ground_range = abs(first_range);
    float sea_range = range_of_sea(view);
    bool sea = sea_range > 0.0 && (ground_range == 0.0 || sea_range < ground_range);
    if (!sea && first_range < 0.0) return;
    float path = sea ? sea_range : ground_range;
    if (path == 0.0) {
        imageStore(radiance, at, vec4(with_clouds(sky_radiance(view) + sun_disc_radiance(view), view, 1e9), 1.0));
        return;
    }

    vec3 surface = frame.eye + path * view;
    float footprint = path * frame.sample_angle;
    Hit hit = Hit(surface, footprint, 0.0);
    if (sea) {
        // On the sea a sample is a long ellipse; its mean diameter counts.
        footprint *= inversesqrt(max(-view.y, 0.02));
        hit = sea_bottom(surface, refract(view, vec3(0.0, 1.0, 0.0), 1.0 / REFRACTIVE_INDEX), footprint);
    }
    vec3 seen = ground_radiance(hit, view, cast_turn(push.origin + at));
    if (sea) seen = sea_radiance(surface, view, footprint, hit, seen);
    imageStore(radiance, at, vec4(with_clouds(veil(seen, view, path), view, path), 1.0));
}
