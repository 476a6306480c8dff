// walk_shaders.c - a soft sky and ground light by the surface's direction, three weak lights from fixed directions so
// that walls differ, the lamps of the room, and ambient occlusion from the depth buffer (after M. Mittring, Finding
// next gen: CryEngine 2, 2007; here samples on a disc around the pixel count by how far they rise over its surface),
// which darkens corners and the floor under furniture.
#include "engine/walk/walk_shaders.h"

#define COMMON                                                                                               \
    "#version 330 core\n"                                                                                    \
    "vec3 sky(vec3 ray) {\n"                                                                                 \
    "    float up = normalize(ray).z;\n"                                                                     \
    "    vec3 above = mix(vec3(0.82, 0.88, 0.93), vec3(0.30, 0.52, 0.82), pow(clamp(up, 0.0, 1.0), "         \
    "0.55));\n"                                                                                              \
    "    return mix(vec3(0.50, 0.56, 0.44), above, smoothstep(-0.03, 0.01, up));\n"                          \
    "}\n"                                                                                                    \
    "vec3 display(vec3 light) {\n"                                                                           \
    "    light = light * 1.08;\n"                                                                            \
    "    light = light * (1.0 + light * 0.18) / (1.0 + light * 0.45);\n"                                     \
    "    return mix(12.92 * light, 1.055 * pow(max(light, 0.0031), vec3(1.0 / 2.4)) - 0.055,\n"              \
    "               step(vec3(0.0031308), light));\n"                                                        \
    "}\n"

const char WALK_SCENE_VERTEX[] =
    "#version 330 core\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 normal;\n"
    "layout(location = 2) in vec4 colour;\n"    // square root of the reflectance, alpha
    "layout(location = 3) in vec4 emission;\n"  // rgb; w: outdoors
    "layout(location = 4) in ivec2 lamps;\n"
    "uniform mat4 clip;\n"
    "uniform vec3 eye;\n"
    "uniform bool one_sided;\n"
    "out vec3 vPosition;\n"
    "flat out vec3 vNormal;\n"
    "flat out vec4 vColour, vEmission;\n"
    "flat out ivec2 vLamps;\n"
    "void main() {\n"
    "    gl_Position = clip * vec4(position - eye, 1.0);\n"
    // Seen from behind: all corners to one place outside the view.
    "    if (one_sided && dot(normal, eye - position) < 0.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);\n"
    "    vPosition = position; vNormal = normal; vLamps = lamps;\n"
    "    vColour = vec4(colour.rgb * colour.rgb, colour.a); vEmission = emission;\n"
    "}\n";

const char WALK_SCENE_FRAGMENT[] = COMMON
    "in vec3 vPosition;\n"
    "flat in vec3 vNormal;\n"
    "flat in vec4 vColour, vEmission;\n"
    "flat in ivec2 vLamps;\n"
    "uniform vec3 eye;\n"
    "uniform samplerBuffer lamps;\n"
    "uniform sampler2D occlusion;\n"
    "uniform vec2 size;\n"
    "out vec4 result;\n"
    "vec3 lamp_light(vec3 n) {\n"
    "    vec3 sum = vec3(0.0);\n"
    "    for (int i = 0; i < vLamps.y; i++) {\n"
    "        vec4 place = texelFetch(lamps, 2 * (vLamps.x + i));\n"
    "        vec3 colour = texelFetch(lamps, 2 * (vLamps.x + i) + 1).rgb;\n"
    "        vec3 way = place.xyz - vPosition;\n"
    "        float r = length(way);\n"
    // Wrapped around the edge: lamps are no points.
    "        float facing = clamp(dot(n, way) / max(r, 0.01) * 0.7 + 0.3, 0.0, 1.0);\n"
    "        sum += mix(colour, vec3(1.0), 0.3) * place.w * facing * 0.85 / (1.0 + 0.22 * r * r);\n"
    "    }\n"
    "    return sum;\n"
    "}\n"
    "void main() {\n"
    "    vec3 view = eye - vPosition;\n"
    "    vec3 n = dot(vNormal, view) < 0.0 ? -vNormal : vNormal;\n"
    "    vec3 light = mix(vec3(0.42, 0.40, 0.37), vec3(0.60, 0.62, 0.65), n.z * 0.5 + 0.5);\n"
    "    light += 0.16 * max(dot(n, vec3(0.48, 0.36, 0.80)), 0.0) * vec3(1.0, 0.96, 0.88);\n"
    "    light += 0.12 * max(dot(n, vec3(-0.80, 0.36, 0.48)), 0.0) * vec3(0.88, 0.94, 1.0);\n"
    "    light += 0.08 * max(dot(n, vec3(0.28, -0.92, 0.28)), 0.0);\n"
    "    if (vEmission.w > 0.5) light = light * 0.75 + 0.75 * max(dot(n, vec3(0.48, 0.36, 0.80)), 0.0) *\n"
    "        vec3(1.0, 0.95, 0.85);\n"
    "    float open = texture(occlusion, gl_FragCoord.xy / size).r;\n"
    "    vec3 shade = mix(vec3(1.0), vec3(open) * mix(vec3(1.0), vec3(1.04, 1.0, 0.96), 1.0 - open), 0.85);\n"
    "    light = light * shade + lamp_light(n) * mix(1.0, open, 0.5);\n"
    "    vec3 out_light = vColour.rgb * light + min(vEmission.rgb, vec3(1.6));\n"
    "    float alpha = vColour.a;\n"
    // Glass mirrors the sky at a grazing angle (Schlick 1994).
    "    if (alpha < 1.0) {\n"
    "        float grazing = pow(1.0 - abs(dot(n, normalize(view))), 5.0);\n"
    "        alpha = min(alpha * 0.5 + 0.04 + 0.6 * grazing, 0.9);\n"
    "        out_light = mix(out_light, vec3(0.75, 0.83, 0.9), 0.6);\n"
    "    }\n"
    "    result = vec4(display(out_light), alpha);\n"
    "}\n";

const char WALK_DEPTH_FRAGMENT[] = "#version 330 core\nvoid main() {}\n";

const char WALK_SCREEN_VERTEX[] = "#version 330 core\n"
                                  "out vec2 at;\n"
                                  "void main() {\n"
                                  "    at = vec2((gl_VertexID & 1) * 4 - 1, (gl_VertexID & 2) * 2 - 1);\n"
                                  // At the far plane, so that what was drawn before stays.
                                  "    gl_Position = vec4(at, 1.0, 1.0);\n"
                                  "}\n";

const char WALK_SKY_FRAGMENT[] =
    COMMON "in vec2 at;\n"
           "uniform vec3 forward, right, up;\n"
           "out vec4 result;\n"
           "void main() { result = vec4(display(sky(forward + at.x * right + at.y * up)), 1.0); }\n";

// Depth d is 1 - near / z. Around each pixel, directions on a spiral disc whose radius is half a metre there; a sample
// counts by how far it rises over the surface's tangent plane, found from the depths themselves.
const char WALK_OCCLUSION_FRAGMENT[] =
    "#version 330 core\n"
    "in vec2 at;\n"
    "uniform sampler2D depth;\n"
    "uniform vec2 tangents;\n"  // of the half angles of the view
    "uniform float near;\n"
    "layout(location = 0) out vec2 result;\n"  // open share, z
    "float z_of(vec2 p) { return near / max(1.0 - texture(depth, p * 0.5 + 0.5).r, 1e-7); }\n"
    "vec3 point(vec2 p) { float z = z_of(p); return vec3(p * tangents * z, z); }\n"
    "void main() {\n"
    "    vec3 centre = point(at);\n"
    "    if (centre.z > 60.0) { result = vec2(1.0, centre.z); return; }\n"
    "    vec2 pixel = 6.0 / vec2(textureSize(depth, 0));\n"
    "    vec3 l = centre - point(at - vec2(pixel.x, 0.0)), r = point(at + vec2(pixel.x, 0.0)) - centre;\n"
    "    vec3 d = centre - point(at - vec2(0.0, pixel.y)), u = point(at + vec2(0.0, pixel.y)) - centre;\n"
    "    vec3 n = normalize(cross(abs(l.z) < abs(r.z) ? l : r, abs(d.z) < abs(u.z) ? d : u));\n"
    "    if (dot(n, centre) > 0.0) n = -n;\n"
    "    const float REACH = 0.55;\n"  // metres
    "    vec2 reach = min(REACH / centre.z / tangents, vec2(0.5));\n"
    "    float turn = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) * "
    "6.2831853;\n"
    "    const int SAMPLES = 14;\n"
    "    float blocked = 0.0;\n"
    "    for (int i = 0; i < SAMPLES; i++) {\n"
    "        float share = (float(i) + 0.5) / float(SAMPLES), angle = turn + float(i) * 2.3999632;\n"
    "        vec3 way = point(at + sqrt(share) * reach * vec2(cos(angle), sin(angle))) - centre;\n"
    "        float far2 = dot(way, way), rise = dot(way, n) - 0.003 - 0.01 * centre.z;\n"
    "        blocked += max(rise, 0.0) * inversesqrt(far2 + 1e-4) * max(1.0 - far2 / (REACH * REACH), 0.0);\n"
    "    }\n"
    "    result = vec2(clamp(1.0 - 1.9 * blocked / float(SAMPLES), 0.0, 1.0), centre.z);\n"
    "}\n";

const char WALK_BLUR_FRAGMENT[] =
    "#version 330 core\n"
    "in vec2 at;\n"
    "uniform sampler2D source;\n"
    "layout(location = 0) out float result;\n"
    "void main() {\n"
    "    ivec2 p = ivec2(gl_FragCoord.xy), most = textureSize(source, 0) - 1;\n"
    "    vec2 here = texelFetch(source, p, 0).rg;\n"
    "    float sum = 0.0, weights = 0.0;\n"
    "    for (int j = -2; j <= 2; j++) for (int i = -2; i <= 2; i++) {\n"
    "        vec2 there = texelFetch(source, clamp(p + ivec2(i, j), ivec2(0), most), 0).rg;\n"
    "        float weight = max(1.0 - abs(there.g - here.g) / (0.05 * here.g), 0.0);\n"
    "        sum += weight * there.r; weights += weight;\n"
    "    }\n"
    "    result = weights > 0.0 ? sum / weights : here.r;\n"
    "}\n";
