// walk_shaders.c - the shaders. The fine look has a soft sky and ground light by the surface's direction, three weak directional lights
// so that walls differ, the lamps of the room, and ambient occlusion from the depth buffer (after M. Mittring, Finding
// next gen: CryEngine 2, 2007; here samples on a disc around the pixel count by how far they rise over its surface),
// which darkens corners and the floor under furniture. In the fast look all of that is baked, and its shaders only show it.
#include "engine/draw/walk_shaders.h"

#include <glad/gl.h>
#include <string.h>

#include "engine/core/arena.h"
#include "engine/draw/walk_mesh.h"
#include "engine/gl/gl_context.h"
#include "engine/shade/walk_shade.h"
#include "radiosity/daylight/daylight.h"

#define VERSION "#version 330 core\n"

#define TRIPLE(name) "const vec3 " #name " = vec3(" WALK_TEXT(WALK_##name) ");\n"
#define NUMBER(name) "const float " #name " = " WALK_TEXT(WALK_##name) ";\n"

// The constants of walk_shade.h, without their prefix.
#define CONSTANTS                                                                                            \
    TRIPLE(BELOW)                                                                                            \
    TRIPLE(ABOVE)                                                                                            \
    TRIPLE(SUN_WAY)                                                                                          \
    TRIPLE(SUN_INDOORS)                                                                                      \
    TRIPLE(SUN_OUTDOORS)                                                                                     \
    TRIPLE(SIDE_WAY)                                                                                         \
    TRIPLE(SIDE)                                                                                             \
    TRIPLE(BACK_WAY)                                                                                         \
    TRIPLE(BACK)                                                                                             \
    NUMBER(OUTDOORS_DIMMING)                                                                                 \
    NUMBER(LAMP_WRAP)                                                                                        \
    NUMBER(LAMP_STRENGTH)                                                                                    \
    NUMBER(LAMP_FALL)                                                                                        \
    NUMBER(LAMP_WHITENESS)                                                                                   \
    NUMBER(LAMP_OPENNESS)                                                                                    \
    NUMBER(OCCLUSION_REACH)                                                                                  \
    NUMBER(OCCLUSION_STRENGTH)                                                                               \
    TRIPLE(OCCLUSION_WARMTH)                                                                                 \
    TRIPLE(PANE)                                                                                             \
    NUMBER(PANE_SHARE)                                                                                       \
    TRIPLE(NIGHT_ZENITH)                                                                                     \
    TRIPLE(NIGHT_HORIZON)                                                                                    \
    TRIPLE(NIGHT_GROUND)                                                                                     \
    NUMBER(NIGHT_PANE)                                                                                       \
    NUMBER(BACK_SHARE)                                                                                       \
    NUMBER(CUT_OUT_LEAST)                                                                                    \
    NUMBER(GLARE)                                                                                            \
    NUMBER(EXPOSURE)                                                                                         \
    NUMBER(SHOULDER_TOP)                                                                                     \
    NUMBER(SHOULDER_BOTTOM)                                                                                  \
    NUMBER(KNEE)

#define DISPLAY                                                                                              \
    "vec3 display(vec3 light) {\n"                                                                           \
    "    light *= EXPOSURE;\n"                                                                               \
    "    light *= (1.0 + light * SHOULDER_TOP) / (1.0 + light * SHOULDER_BOTTOM);\n"                         \
    "    vec3 over = max(light - KNEE, 0.0) / (1.0 - KNEE);\n"                                               \
    "    light = min(light, KNEE) + (1.0 - KNEE) * (1.0 - exp(-over));\n"                                    \
    "    return mix(12.92 * light, 1.055 * pow(max(light, 0.0031), vec3(1.0 / 2.4)) - 0.055,\n"              \
    "               step(vec3(0.0031308), light));\n"                                                        \
    "}\n"

// Glass mirrors the sky more at a grazing angle (Schlick 1994).
#define GLASS                                                                                                \
    "float glass(float alpha, vec3 n, vec3 view) {\n"                                                        \
    "    float around = 1.0 - abs(dot(n, normalize(view))), square = around * around;\n"                     \
    "    return min(alpha * 0.5 + 0.04 + 0.6 * square * square * around, 0.9);\n"                            \
    "}\n"

// Where a program is made with PICTURES (walk_textures.h), the place of a vertex in its picture and the strength of the texels; else 1.
#define PICTURE_VERTEX                                                                                       \
    "#ifdef PICTURES\n"                                                                                      \
    "layout(location = 10) in vec3 picture;\n"                                                               \
    "layout(location = 11) in vec4 strength;\n"                                                              \
    "out vec3 vPicture;\n"                                                                                   \
    "vec4 picture_strength() { vPicture = picture; return strength; }\n"                                     \
    "#else\n"                                                                                                \
    "vec4 picture_strength() { return vec4(1.0); }\n"                                                        \
    "#endif\n"

// Where a program is made with MIRRORS, what is seen in a mirror lies before its plane: n . p + d >= 0.
#define BEFORE_VERTEX                                                                                        \
    "#ifdef MIRRORS\n"                                                                                       \
    "uniform vec4 mirror;\n"                                                                                 \
    "void keep_before(vec3 p) { gl_ClipDistance[0] = dot(mirror, vec4(p, 1.0)); }\n"                         \
    "#else\n"                                                                                                \
    "void keep_before(vec3 p) {}\n"                                                                          \
    "#endif\n"

// The root of the picture's colour, and its opacity.
#define PICTURE_FRAGMENT                                                                                     \
    "#ifdef PICTURES\n"                                                                                      \
    "in vec3 vPicture;\n"                                                                                    \
    "uniform sampler2DArray pictures;\n"                                                                     \
    "vec4 picture_texel() { return texture(pictures, vPicture); }\n"                                         \
    "#else\n"                                                                                                \
    "vec4 picture_texel() { return vec4(1.0); }\n"                                                           \
    "#endif\n"

const char WALK_FINE_VERTEX[] = VERSION PICTURE_VERTEX BEFORE_VERTEX
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 normal;\n"
    "layout(location = 2) in vec4 colour;\n"    // square root of the reflectance, alpha
    "layout(location = 3) in vec4 emission;\n"  // rgb; w: outdoors
    "layout(location = 4) in ivec2 lamps;\n"
    "uniform mat4 clip;\n"
    "uniform vec3 eye;\n"
    "out vec3 vPosition;\n"
    "flat out vec3 vNormal;\n"
    "flat out vec4 vColour, vEmission;\n"
    "flat out ivec2 vLamps;\n"
    "void main() {\n"
    "    gl_Position = clip * vec4(position - eye, 1.0); keep_before(position);\n"
    "    vPosition = position; vNormal = normal; vLamps = lamps;\n"
    "    vColour = vec4(colour.rgb * colour.rgb, colour.a) * picture_strength(); vEmission = emission;\n"
    "}\n";

const char WALK_FINE_FRAGMENT[] = VERSION CONSTANTS DISPLAY GLASS PICTURE_FRAGMENT
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
    "        float r2 = dot(way, way), cosine = dot(n, way) / max(sqrt(r2), 0.01);\n"
    "        float facing = clamp(cosine * (1.0 - LAMP_WRAP) + LAMP_WRAP, 0.0, 1.0);\n"
    "        sum += mix(colour, vec3(1.0), LAMP_WHITENESS) * place.w * facing *\n"
    "               LAMP_STRENGTH / (1.0 + LAMP_FALL * r2);\n"
    "    }\n"
    "    return sum;\n"
    "}\n"
    "void main() {\n"
    "    vec3 view = eye - vPosition;\n"
    "    vec3 n = dot(vNormal, view) < 0.0 ? -vNormal : vNormal;\n"
    "    float sun = max(dot(n, SUN_WAY), 0.0);\n"
    "    vec3 light = mix(BELOW, ABOVE, n.z * 0.5 + 0.5) + SUN_INDOORS * sun +\n"
    "                 SIDE * max(dot(n, SIDE_WAY), 0.0) + BACK * max(dot(n, BACK_WAY), 0.0);\n"
    "    if (vEmission.w > 0.5) light = light * OUTDOORS_DIMMING + SUN_OUTDOORS * sun;\n"
    "    float open = texture(occlusion, gl_FragCoord.xy / size).r;\n"
    "    vec3 warm = open * mix(vec3(1.0), OCCLUSION_WARMTH, 1.0 - open);\n"
    "    light = light * mix(vec3(1.0), warm, OCCLUSION_STRENGTH) +\n"
    "            lamp_light(n) * mix(1.0, open, LAMP_OPENNESS);\n"
    "    vec4 texel = picture_texel();\n"
    "    vec3 out_light = vColour.rgb * (texel.rgb * texel.rgb) * light + vEmission.rgb;\n"
    "#ifdef CUT_OUT\n"
    "    float alpha = min(vColour.a * texel.a, 1.0);\n"
    "    if (alpha < CUT_OUT_LEAST) discard;\n"
    "#else\n"
    "    float alpha = vColour.a;\n"
    "    if (alpha < 1.0) {\n"
    "        alpha = glass(alpha, n, view);\n"
    "        out_light = mix(out_light, PANE, PANE_SHARE);\n"
    "    }\n"
    "#endif\n"
    "    result = vec4(display(out_light), alpha);\n"
    "}\n";

const char WALK_DEPTH_FRAGMENT[] = VERSION "void main() {}\n";

const char WALK_BAKED_VERTEX[] = VERSION PICTURE_VERTEX BEFORE_VERTEX
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 5) in vec4 front;\n"
    "layout(location = 7) in vec2 place;\n"
    "uniform mat4 clip;\n"
    "uniform vec3 eye;\n"
    "flat out vec3 vColour;\n"
    "out vec2 vPlace;\n"
    "void main() {\n"
    "    gl_Position = clip * vec4(position - eye, 1.0); keep_before(position);\n"
    "    vColour = front.rgb * sqrt(picture_strength().rgb); vPlace = place;\n"
    "}\n";

const char WALK_BAKED_FRAGMENT[] = VERSION PICTURE_FRAGMENT
    "flat in vec3 vColour;\n"
    "in vec2 vPlace;\n"
    "uniform sampler2D atlas;\n"
    "out vec4 result;\n"
    "void main() { result = vec4(vColour * texture(atlas, vPlace).r * picture_texel().rgb, 1.0); }\n";

// Polygons have colours for both sides; all corners of a polygon choose the same side, since it is flat.
const char WALK_THING_VERTEX[] = VERSION PICTURE_VERTEX BEFORE_VERTEX
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 normal;\n"
    "layout(location = 5) in vec4 front;\n"
    "layout(location = 6) in vec4 back;\n"
    "uniform mat4 clip;\n"
    "uniform vec3 eye;\n"
    "out vec4 vColour;\n"
    "out vec3 vView;\n"
    "flat out vec3 vNormal;\n"
    "void main() {\n"
    "    gl_Position = clip * vec4(position - eye, 1.0); keep_before(position);\n"
    "    vView = eye - position; vNormal = normal;\n"
    "    vec4 shown = picture_strength();\n"
    "    vColour = (dot(normal, vView) < 0.0 ? back : front) *\n"
    "              vec4(sqrt(shown.rgb), shown.a);\n"
    "}\n";

const char WALK_THING_FRAGMENT[] =
    VERSION CONSTANTS PICTURE_FRAGMENT "in vec4 vColour;\n"
                                       "out vec4 result;\n"
                                       "void main() {\n"
                                       "    result = vColour * picture_texel();\n"
                                       "#ifdef CUT_OUT\n"
                                       "    if (result.a < CUT_OUT_LEAST) discard;\n"
                                       "#endif\n"
                                       "}\n";

const char WALK_PANE_FRAGMENT[] = VERSION CONSTANTS GLASS
    "in vec4 vColour;\n"
    "in vec3 vView;\n"
    "flat in vec3 vNormal;\n"
    "uniform float day;\n"
    "out vec4 result;\n"
    "void main() {\n"
    "    result = vec4(vColour.rgb * mix(NIGHT_PANE, 1.0, day), glass(vColour.a, vNormal, vView));\n"
    "}\n";

#define LIT_PLACES                                                                                           \
    "layout(location = 0) in vec3 position;\n"                                                               \
    "layout(location = 1) in vec3 normal;\n"                                                                 \
    "layout(location = 4) in int material;\n"                                                                \
    "layout(location = 5) in uvec2 shines;\n" /* does it emit, is it outdoors */                             \
    "layout(location = 8) in vec3 before;\n"                                                                 \
    "layout(location = 9) in vec3 light;\n"                                                                  \
    "uniform mat4 clip;\n"                                                                                   \
    "uniform vec3 eye;\n"                                                                                    \
    "uniform float fade;\n"

// Light is computed as if the back of a face reflected nothing. But curtains and leaves are single polygons: their backs show
// some of their front's light. Lamps stay bright however low the exposure is.
const char WALK_LIT_VERTEX[] = VERSION CONSTANTS PICTURE_VERTEX BEFORE_VERTEX LIT_PLACES
    "uniform float exposure, exposure_outdoors;\n"
    "centroid out vec3 vLight;\n"
    "void main() {\n"
    "    gl_Position = clip * vec4(position - eye, 1.0); keep_before(position);\n"
    "    vLight = mix(before, light, fade) * picture_strength().rgb;\n"
    "    vLight *= shines.y == 1u ? exposure_outdoors : exposure;\n"
    "    bool front = dot(normal, eye - position) >= 0.0;\n"
    "    if (!front) vLight *= BACK_SHARE;\n"
    "    float most = max(max(vLight.r, vLight.g), max(vLight.b, 1e-20));\n"
    "    if (front && shines.x == 1u) vLight *= max(GLARE / most, 1.0);\n"
    "}\n";

// The curve of walk_shade.h, then IEC 61966-2-1 (sRGB) by three square roots, within a 256th of it: computing a power at each pixel takes
// longer than everything else.
const char WALK_LIT_FRAGMENT[] = VERSION CONSTANTS PICTURE_FRAGMENT
    "centroid in vec3 vLight;\n"
    "out vec4 result;\n"
    "void main() {\n"
    "    vec3 texel = picture_texel().rgb;\n"
    "    vec3 x = max(vLight, 0.0) * (texel * texel);\n"
    "    x = min(" WALK_TEXT(WALK_CURVE(
        x)) ", 1.0);\n"
            "    vec3 a = sqrt(x), b = sqrt(a), c = sqrt(b);\n"
            "    vec3 y = 0.662002687 * a + 0.684122060 * b - 0.323583601 * c - 0.0225411470 * x;\n"
            "    result = vec4(mix(12.92 * x, y, step(vec3(0.0031308), x)), 1.0);\n"
            "}\n";

// The arriving light is the leaving light less the emission, divided by the reflectance; -1 where nothing is reflected, since it is then
// unknown.
const char WALK_FALSE_VERTEX[] = VERSION BEFORE_VERTEX LIT_PLACES
    "uniform samplerBuffer materials;\n"
    "uniform vec3 weights;\n"
    "uniform bool arriving;\n"
    "centroid out float vValue;\n"
    "void main() {\n"
    "    gl_Position = clip * vec4(position - eye, 1.0); keep_before(position);\n"
    "    vec3 value = mix(before, light, fade);\n"
    "    if (arriving) {\n"
    "        vec3 rho = texelFetch(materials, 2 * material).rgb;\n"
    "        value = max(value - texelFetch(materials, 2 * material + 1).rgb, 0.0) / max(rho, 1e-20);\n"
    "        if (min(rho.r, min(rho.g, rho.b)) == 0.0) value = vec3(-1.0);\n"
    "    }\n"
    "    vValue = dot(value, weights);\n"
    "}\n";

const char WALK_FALSE_FRAGMENT[] = VERSION "centroid in float vValue;\n"
                                           "uniform sampler2D scale;\n"
                                           "uniform float low, octaves;\n"  // of the scale
                                           "out vec4 result;\n"
                                           "void main() {\n"
                                           "    float place = log2(max(vValue, 1e-20) / low) / octaves;\n"
                                           "    vec3 colour = texture(scale, vec2(place, 0.5)).rgb;\n"
                                           "    result = vec4(vValue < 0.0 ? vec3(0.35) : colour, 1.0);\n"
                                           "}\n";

const char WALK_LINE_VERTEX[] = VERSION BEFORE_VERTEX
    "layout(location = 0) in vec3 position;\n"
    "uniform mat4 clip;\n"
    "uniform vec3 eye;\n"
    "void main() { gl_Position = clip * vec4(position - eye, 1.0); keep_before(position); }\n";

const char WALK_LINE_FRAGMENT[] = VERSION "uniform vec4 colour;\n"
                                          "out vec4 result;\n"
                                          "void main() { result = colour; }\n";

// The mirror's picture has the pixels of the frame; its alpha is the share of a pixel's samples that the mirror covers, by which its
// colours are multiplied. Light times the mirror's share is shown, near a screen's curve, by its root; what the mirror scatters
// itself stays in the rest (blending GL_ONE, GL_ONE_MINUS_SRC_ALPHA).
const char WALK_MIRROR_FRAGMENT[] =
    VERSION "uniform sampler2D image;\n"
            "uniform float share;\n"
            "out vec4 result;\n"
            "void main() {\n"
            "    vec4 seen = texelFetch(image, ivec2(gl_FragCoord.xy), 0);\n"
            "    result = vec4(sqrt(share) * seen.rgb / max(seen.a, 1.0 / 255.0), share);\n"
            "}\n";

const char WALK_SCREEN_VERTEX[] =
    VERSION "out vec2 at;\n"
            "void main() {\n"
            "    at = vec2((gl_VertexID & 1) * 4 - 1, (gl_VertexID & 2) * 2 - 1);\n"
            // The sky lies at the far plane, so that everything drawn before stays.
            "    gl_Position = vec4(at, 1.0, 1.0);\n"
            "}\n";

// The sky is mixed from three display colours, which a compiler computes once: a power at each pixel took longer than everything else.
// The sky of baked light is that of daylight_seen: radiosities times exposure, by direction.
const char WALK_SKY_FRAGMENT[] = VERSION CONSTANTS DISPLAY
    "#ifdef PICTURES\n"
    "uniform sampler2D pictures;\n"
    "uniform vec3 strength;\n"  // of its texels, squared
    "uniform float start;\n"
    "vec3 picture(vec3 ray, float rise) {\n"
    "    vec2 place = vec2(start - atan(ray.y, ray.x), acos(clamp(rise, 0.0, 1.0)) * 4.0) / 6.2831853;\n"
    "    vec3 texel = textureLod(pictures, place, 0.0).rgb;\n"
    "    return strength * texel * texel;\n"
    "}\n"
    "#endif\n"
    "in vec2 at;\n"
    "uniform vec3 forward, right, up;\n"
    "uniform float day;\n"
    "uniform bool lit;\n"
    "uniform vec3 sun, lit_ground;\n"
    "uniform vec3 overhead;\n"  // over the product of gradation and indicatrix there
    "uniform vec2 gradation;\n"
    "uniform vec3 indicatrix;\n"
    "uniform float sun_shines;\n"
    "out vec4 result;\n"
    "vec3 screen(vec3 light) {\n"
    "    vec3 x = min(light, " WALK_TEXT(
        WALK_WHITE) ");\n"
                    "    x = min(" WALK_TEXT(WALK_CURVE(
                        x)) ", 1.0);\n"
                            "    return mix(12.92 * x, 1.055 * pow(max(x, 0.0031), vec3(1.0 / 2.4)) - 0.055, "
                            "step(vec3(0.0031308), x));\n"
                            "}\n"
                            "void main() {\n"
                            "    vec3 ray = forward + at.x * right + at.y * up;\n"
                            "    float rise = ray.z * inversesqrt(dot(ray, ray));\n"
                            "    if (lit) {\n"
                            "        vec3 w = normalize(vec3(ray.xy, max(ray.z, 0.001 * length(ray))));\n"
                            "        float cosine = clamp(dot(w, sun), -1.0, 1.0), angle = acos(cosine);\n"
                            "        float about = 1.0 + indicatrix.x * (exp(indicatrix.y * angle) - "
                            "exp(indicatrix.y * 1.57079633))\n"
                            "                    + indicatrix.z * cosine * cosine;\n"
                            "        vec3 sky = overhead * about * (1.0 + gradation.x * exp(gradation.y / "
                            "w.z));\n"
                            "        float away = length(normalize(ray) - sun) / " WALK_TEXT(
                                DAYLIGHT_SUN_RADIUS) ";\n"
                                                     "        float disc = sun_shines * (1.0 - "
                                                     "smoothstep(0.9, 1.1, away)) * step(0.0, rise);\n"
                                                     "        sky = mix(sky, vec3(" WALK_TEXT(
                                                         WALK_WHITE) "), disc);\n"
                                                                     "#ifdef PICTURES\n"
                                                                     "        sky = picture(ray, rise);\n"
                                                                     "#endif\n"
                                                                     "        float above = "
                                                                     "smoothstep(-" WALK_TEXT(
                                                                         DAYLIGHT_HAZE) ", 0.0, rise);\n"
                                                                                        "        result = "
                                                                                        "vec4(screen(mix(lit_"
                                                                                        "ground, sky, "
                                                                                        "above)), 1.0);\n"
                                                                                        "        return;\n"
                                                                                        "    }\n"
                                                                                        "    vec3 zenith = "
                                                                                        "display(mix(NIGHT_"
                                                                                        "ZENITH, vec3(0.30, "
                                                                                        "0.52, 0.82), "
                                                                                        "day));\n"
                                                                                        "    vec3 horizon = "
                                                                                        "display(mix(NIGHT_"
                                                                                        "HORIZON, vec3(0.82, "
                                                                                        "0.88, 0.93), "
                                                                                        "day));\n"
                                                                                        "    vec3 ground = "
                                                                                        "display(mix(NIGHT_"
                                                                                        "GROUND, vec3(0.50, "
                                                                                        "0.56, 0.44), "
                                                                                        "day));\n"
                                                                                        "    vec3 above = "
                                                                                        "mix(horizon, "
                                                                                        "zenith, 0.97 * "
                                                                                        "sqrt(max(rise, "
                                                                                        "0.0)));\n"
                                                                                        "#ifdef PICTURES\n"
                                                                                        "    above = "
                                                                                        "display(picture(ray,"
                                                                                        " rise));\n"
                                                                                        "#endif\n"
                                                                                        "    result = "
                                                                                        "vec4(mix(ground, "
                                                                                        "above, "
                                                                                        "smoothstep(-0.03, "
                                                                                        "0.01, rise)), "
                                                                                        "1.0);\n"
                                                                                        "}\n";

// Depth d is 1 - near / z. Samples around each pixel lie on a spiral in a disc, whose radius is half a metre at the pixel's depth; a
// sample counts by how far it rises over the surface's tangent plane, which is found from the depths themselves.
const char WALK_OCCLUSION_FRAGMENT[] = VERSION CONSTANTS
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
    "    vec2 reach = min(OCCLUSION_REACH / centre.z / tangents, vec2(0.5));\n"
    "    float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));\n"
    "    const int SAMPLES = 14;\n"
    "    float blocked = 0.0;\n"
    "    for (int i = 0; i < SAMPLES; i++) {\n"
    "        float share = (float(i) + 0.5) / float(SAMPLES);\n"
    "        float angle = noise * 6.2831853 + float(i) * 2.3999632;\n"
    "        vec3 way = point(at + sqrt(share) * reach * vec2(cos(angle), sin(angle))) - centre;\n"
    "        float far2 = dot(way, way), rise = dot(way, n) - 0.003 - 0.01 * centre.z;\n"
    "        float near_by = max(1.0 - far2 / (OCCLUSION_REACH * OCCLUSION_REACH), 0.0);\n"
    "        blocked += max(rise, 0.0) * inversesqrt(far2 + 1e-4) * near_by;\n"
    "    }\n"
    "    result = vec2(clamp(1.0 - 1.9 * blocked / float(SAMPLES), 0.0, 1.0), centre.z);\n"
    "}\n";

const char WALK_BLUR_FRAGMENT[] =
    VERSION "in vec2 at;\n"
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

unsigned walk_program(const char *vertex, const char *fragment, int flags, Error *error) {
    Arena scratch = {0};
    const char *source[2] = {vertex, fragment};
    char *text[2];
    for (int i = 0; i < 2; i++) {
        // The first line is the version, which no other line may come before.
        int version = (int)(strchr(source[i], '\n') - source[i]) + 1;
        text[i] = arena_format(&scratch, "%.*s%s%s%s%s", version, source[i],
                               flags & SHADER_PICTURES ? "#define PICTURES\n" : "",
                               flags & SHADER_CUT_OUT ? "#define CUT_OUT\n" : "",
                               flags & SHADER_MIRRORS ? "#define MIRRORS\n" : "", source[i] + version);
    }
    unsigned program = gl_program(text[0], text[1], error);
    if (program && flags & SHADER_PICTURES) {
        glUseProgram(program);
        glUniform1i(glGetUniformLocation(program, "pictures"), WALK_UNIT_PICTURES);
    }
    arena_free(&scratch);
    return program;
}
