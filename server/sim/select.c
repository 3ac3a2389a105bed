/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/select.h"
#include "sim/intrinsics.h"

/* A search is compiled for each of these, as SelectNear. */
#define NEAR_FUNCTION(name, target, way, dim, periodic)                                                                \
    target static size_t name##_##way(const Points *points, uint32_t first, uint32_t last, const double at[3],         \
                                      double distance2, uint32_t self, uint32_t *out, bool *images)                    \
    {                                                                                                                  \
        return name(points, first, last, at, distance2, self, out, images, dim, periodic);                             \
    }
#define NEAR_FUNCTIONS(name, target)                                                                                   \
    NEAR_FUNCTION(name, target, 2, 2, false)                                                                           \
    NEAR_FUNCTION(name, target, 3, 3, false)                                                                           \
    NEAR_FUNCTION(name, target, periodic_2, 2, true)                                                                   \
    NEAR_FUNCTION(name, target, periodic_3, 3, true)
#define NEAR_TABLE(name)                                                                                               \
    {                                                                                                                  \
        {name##_2, name##_3},                                                                                          \
        {                                                                                                              \
            name##_periodic_2, name##_periodic_3                                                                       \
        }                                                                                                              \
    }

NEAR_FUNCTIONS(plain_near, )
#if HAS_LEVELS
NEAR_FUNCTIONS(near_3, FOR_V3)
NEAR_FUNCTIONS(near_4, FOR_V4)
#endif

OPAQUE void select_marks(Level level, const double *r, size_t stride, size_t blocks, double reach, uint8_t *marks)
{
    (void)level;
#if HAS_LEVELS
    if (level == LEVEL_V4) {
        marks_4(r, stride, blocks, reach, marks);
        return;
    }
    if (level == LEVEL_V3) {
        marks_3(r, stride, blocks, reach, marks);
        return;
    }
#endif
    plain_marks(r, stride, blocks, reach, marks);
}

size_t select_marked(Level level, const uint32_t *list, size_t n, const uint8_t *bits, uint32_t *out)
{
    (void)level;
#if HAS_LEVELS
    if (level == LEVEL_V4) return marked_4(list, n, bits, out);
    if (level == LEVEL_V3) return marked_3(list, n, bits, out);
#endif
    return plain_marked(list, n, bits, out);
}

SelectNear select_near(Level level, int dim, bool periodic)
{
    static const SelectNear functions[LEVELS][2][2] = {
        [LEVEL_BASE] = NEAR_TABLE(plain_near),
#if HAS_LEVELS
        [LEVEL_V3] = NEAR_TABLE(near_3),
        [LEVEL_V4] = NEAR_TABLE(near_4),
#endif
    };
    return functions[level][periodic][dim - 2];
}
