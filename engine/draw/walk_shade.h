// walk_shade.h - the light of a walk, until there is real light, in numbers: said once for what is baked in C and for
// the shaders. As lists, since a triple is written differently in the two: `(Rgb){WALK_BELOW}`, `vec3(...)`.
#ifndef WALK_SHADE_H
#define WALK_SHADE_H

// A list or a number as text, for a shader.
#define WALK_TEXT(...) WALK_TEXT_OF(__VA_ARGS__)
#define WALK_TEXT_OF(...) #__VA_ARGS__

// Soft light from the ground and from the sky, mixed by how far a surface faces up.
#define WALK_BELOW 0.42f, 0.40f, 0.37f
#define WALK_ABOVE 0.60f, 0.62f, 0.65f
// Three weak lights from afar, so that walls differ; out of doors the first is the sun, and the soft light is weaker.
#define WALK_SUN_WAY 0.48, 0.36, 0.80
#define WALK_SUN_INDOORS 0.160f, 0.154f, 0.141f
#define WALK_SUN_OUTDOORS 0.75f, 0.7125f, 0.6375f
#define WALK_SIDE_WAY -0.80, 0.36, 0.48
#define WALK_SIDE 0.106f, 0.113f, 0.120f
#define WALK_BACK_WAY 0.28, -0.92, 0.28
#define WALK_BACK 0.08f, 0.08f, 0.08f
#define WALK_OUTDOORS_DIMMING 0.75f

// Lamps are no points: their light reaches a little around the edge, and does not grow without bound near by.
#define WALK_LAMP_WRAP 0.3f
#define WALK_LAMP_STRENGTH 0.85f
#define WALK_LAMP_FALL 0.22f      // 1/m^2
#define WALK_LAMP_WHITENESS 0.3f  // eyes take a lamp's own colour for white in part
#define WALK_LAMP_OPENNESS 0.5f   // how much of the ambient occlusion dims lamps too

// Ambient occlusion: how far what is near darkens, metres; its strength; the warmth of what is left.
#define WALK_OCCLUSION_REACH 0.55
#define WALK_OCCLUSION_STRENGTH 0.85f
#define WALK_OCCLUSION_WARMTH 1.04f, 1.00f, 0.96f

// Panes take on some of the sky.
#define WALK_PANE 0.75f, 0.83f, 0.90f
#define WALK_PANE_SHARE 0.6f

// Light by radiosity: what the back of a polygon shows of its front's light; how bright a lamp is at least, and from where on
// all is white, both in exposed light, of which 1 becomes half the screen's.
#define WALK_BACK_SHARE 0.75
#define WALK_GLARE 12.0
#define WALK_WHITE 10.0

// The exposure on a screen: each channel by the curve of Reinhard, Stark, Shirley & Ferwerda (2002, equation 4), so that what is
// too bright turns white with its hue. In C and in shaders.
#define WALK_CURVE(x) (x) * (1.0 + (x) / (WALK_WHITE * WALK_WHITE)) / (1.0 + (x))

// Light by radiosity is that of lamps: outside it is night, and panes mirror little.
#define WALK_NIGHT_ZENITH 0.0015, 0.0025, 0.0065
#define WALK_NIGHT_HORIZON 0.010, 0.014, 0.025
#define WALK_NIGHT_GROUND 0.0010, 0.0010, 0.0012
#define WALK_NIGHT_PANE 0.15

// To the screen: a little brighter, a shoulder, then the curve of IEC 61966-2-1 (sRGB).
#define WALK_EXPOSURE 1.08f
#define WALK_SHOULDER_TOP 0.18f
#define WALK_SHOULDER_BOTTOM 0.45f

#endif
