// Radiance of ground and sea. The includer declares the images of ground and light; what it includes stands before.
#ifndef SHADE_GLSL
#define SHADE_GLSL

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

#endif
