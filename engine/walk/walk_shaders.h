// walk_shaders.h - the shaders of the walk's renderer.
#ifndef WALK_SHADERS_H
#define WALK_SHADERS_H

extern const char WALK_SCENE_VERTEX[], WALK_SCENE_FRAGMENT[];  // surfaces
extern const char WALK_DEPTH_FRAGMENT[];                       // nothing but depth
extern const char WALK_SCREEN_VERTEX[];                        // one triangle over the whole frame
extern const char WALK_SKY_FRAGMENT[];
extern const char WALK_OCCLUSION_FRAGMENT[], WALK_BLUR_FRAGMENT[];

#endif
