// Rays through the structures of a device that traces them itself (`VK_KHR_ray_query`): the twin of `lib/bvh.glsl`. The
// includer declares the structure `world`, whose instances are the `placements`.
#ifndef QUERY_GLSL
#define QUERY_GLSL

#include "lib/hit.glsl"
#include "lib/placements.glsl"
#include "lib/tree.glsl"

// The nearest triangle before `reach`; any of them if `any_`.
Hit trace(vec3 origin, vec3 direction, float reach, const bool any_) {
    const uint flags = gl_RayFlagsOpaqueEXT | (any_ ? gl_RayFlagsTerminateOnFirstHitEXT : 0u);
    rayQueryEXT query;
    rayQueryInitializeEXT(query, world, flags, 0xffu, origin, 0.0, direction, reach);
    while (rayQueryProceedEXT(query)) {}
    if (rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionNoneEXT) {
        return Hit(reach, 0.0, 0.0, 0u, NOTHING);
    }
    uint placement = rayQueryGetIntersectionInstanceIdEXT(query, true);
    uint triangle = placement_at(placement).first + rayQueryGetIntersectionPrimitiveIndexEXT(query, true);
    vec2 weights = rayQueryGetIntersectionBarycentricsEXT(query, true);
    return Hit(rayQueryGetIntersectionTEXT(query, true), weights.x, weights.y, placement, triangle);
}

#endif
