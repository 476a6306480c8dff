// walk_shade.h - the constants of a walk's light as long as no light was computed, shared by the baking in C and the shaders. Triples
// are plain lists, because C and shaders write a triple differently: `(Rgb){WALK_BELOW}`, `vec3(...)`.
#ifndef WALK_SHADE_H
#define WALK_SHADE_H

// Turns a list or a number into text, for a shader.
#define WALK_TEXT(...) WALK_TEXT_OF(__VA_ARGS__)
#define WALK_TEXT_OF(...) #__VA_ARGS__

// Soft light from the ground and from the sky, mixed by how far a surface faces up.
#define WALK_BELOW 0.42f, 0.40f, 0.37f
#define WALK_ABOVE 0.60f, 0.62f, 0.65f
// Three weak directional lights make walls differ; out of doors the first is the sun, and the soft light is weaker.
#define WALK_SUN_WAY 0.48, 0.36, 0.80
#define WALK_SUN_INDOORS 0.160f, 0.154f, 0.141f
#define WALK_SUN_OUTDOORS 0.75f, 0.7125f, 0.6375f
#define WALK_SIDE_WAY -0.80, 0.36, 0.48
#define WALK_SIDE 0.106f, 0.113f, 0.120f
#define WALK_BACK_WAY 0.28, -0.92, 0.28
#define WALK_BACK 0.08f, 0.08f, 0.08f
#define WALK_OUTDOORS_DIMMING 0.75f

// Lamps are no points: their light reaches surfaces that face a little away, and stays bounded near the lamp.
#define WALK_LAMP_WRAP 0.3f
#define WALK_LAMP_STRENGTH 0.85f
#define WALK_LAMP_FALL 0.22f      // 1/m^2
#define WALK_LAMP_WHITENESS 0.3f  // the eye takes part of a lamp's own colour for white
#define WALK_LAMP_OPENNESS 0.5f   // the share of the ambient occlusion that dims lamps too

// Ambient occlusion: the distance within which things darken a point, metres; its strength; the warm tint of the light left over.
#define WALK_OCCLUSION_REACH 0.55
#define WALK_OCCLUSION_STRENGTH 0.85f
#define WALK_OCCLUSION_WARMTH 1.04f, 1.00f, 0.96f

// Panes take on this share of the sky's colour.
#define WALK_PANE 0.75f, 0.83f, 0.90f
#define WALK_PANE_SHARE 0.6f

// Texels of a picture that cover less than this are not drawn.
#define WALK_CUT_OUT_LEAST 0.125

// Where a building has a picture of its sky and no light was computed, its mean luminance: that of the sky shown otherwise.
#define WALK_SKY_LUMINANCE 0.63f

// Light by radiosity: the share of its front's light that the back of a polygon shows; the least brightness of a lamp, and the brightness
// that is shown as full white, both in exposed light, of which 1 becomes half the screen's.
#define WALK_BACK_SHARE 0.75
#define WALK_GLARE 12.0
#define WALK_WHITE 10.0

// The exposure on a screen: each channel follows the curve of Reinhard, Stark, Shirley & Ferwerda (2002, equation 4), by which light that
// is too bright fades to white in its own hue. For C and for shaders.
#define WALK_CURVE(x) (x) * (1.0 + (x) / (WALK_WHITE * WALK_WHITE)) / (1.0 + (x))

// Light by radiosity comes from lamps alone: outside it is night, and panes mirror little.
#define WALK_NIGHT_ZENITH 0.0015, 0.0025, 0.0065
#define WALK_NIGHT_HORIZON 0.010, 0.014, 0.025
#define WALK_NIGHT_GROUND 0.0010, 0.0010, 0.0012
#define WALK_NIGHT_PANE 0.15

// Light becomes a screen's value by a factor a little above 1, a bend, then the curve of IEC 61966-2-1 (sRGB). Up to the knee that is
// all; above it the value nears 1 without reaching it, so that what a lamp shines on keeps its shading and its hue.
#define WALK_EXPOSURE 1.08f
#define WALK_SHOULDER_TOP 0.18f
#define WALK_SHOULDER_BOTTOM 0.45f
#define WALK_KNEE 0.7f

#endif
