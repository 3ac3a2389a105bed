/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/select.h"

#if HAS_LEVELS
#include <immintrin.h>
#endif

static void plain_marks(const double *r, size_t stride, size_t blocks, double reach, uint8_t *marks)
{
    for (size_t b = 0; b < blocks; b++) {
        unsigned bits = 0;
        for (unsigned l = 0; l < 8; l++) bits |= (unsigned)(r[b * stride + l] < reach) << l;
        marks[b] = (uint8_t)bits;
    }
}

static size_t plain_marked(const uint32_t *list, size_t n, const uint8_t *bits, uint32_t *out)
{
    size_t count = 0;
    for (size_t k = 0; k < n; k++) {
        out[count] = list[k];
        count += (unsigned)bits[k / 8] >> k % 8 & 1u;
    }
    return count;
}

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

/* Differences to nearest images are those of model_nearest(). */
INLINE size_t plain_near(const Points *points, uint32_t first, uint32_t last, const double at[3], double distance2,
                         uint32_t self, uint32_t *out, bool *images, int dim, bool periodic)
{
    size_t count = 0;
    for (uint32_t j = first; j < last; j++) {
        bool image = false;
        double r2 = 0;
        for (int d = 0; d < dim; d++) {
            double x = at[d] - points->x[d][j];
            if (periodic) {
                const double k = __builtin_rint(x * points->frequency[d]);
                image |= k != 0;
                x -= points->period[d] * k;
            }
            r2 += x * x;
        }
        const bool near = (r2 < distance2) & (j != self);
        out[count] = j;
        count += near;
        *images |= near & image;
    }
    return count;
}
NEAR_FUNCTIONS(plain_near, )

#if HAS_LEVELS

/* AVX2 has no instruction that moves what is picked to the front, but a permutation for each of the 256 ways to pick of eight does:
 * byte k is the number of the k-th bit that is set. (BMI2 would make them on the fly; some machines take 200 cycles for it.) */
#define NUMBER(bits, l) (((bits) >> (l)&1) ? (uint64_t)(l) << 8 * __builtin_popcount((bits) & ((1u << (l)) - 1)) : 0)
#define PICK(bits)                                                                                                     \
    (NUMBER(bits, 0) | NUMBER(bits, 1) | NUMBER(bits, 2) | NUMBER(bits, 3) | NUMBER(bits, 4) | NUMBER(bits, 5) |       \
     NUMBER(bits, 6) | NUMBER(bits, 7))
#define PICK_4(bits)  PICK(bits), PICK(bits + 1u), PICK(bits + 2u), PICK(bits + 3u)
#define PICK_16(bits) PICK_4(bits), PICK_4(bits + 4u), PICK_4(bits + 8u), PICK_4(bits + 12u)
#define PICK_64(bits) PICK_16(bits), PICK_16(bits + 16u), PICK_16(bits + 32u), PICK_16(bits + 48u)
static const uint64_t PICKS[256] = {PICK_64(0u), PICK_64(64u), PICK_64(128u), PICK_64(192u)};

FOR_V3 static inline __m256i picked_3(__m256i j, unsigned bits)
{
    return _mm256_permutevar8x32_epi32(j, _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((long long)PICKS[bits])));
}

FOR_V3 static void marks_3(const double *r, size_t stride, size_t blocks, double reach, uint8_t *marks)
{
    const __m256d limit = _mm256_set1_pd(reach);
    for (size_t b = 0; b < blocks; b++) {
        const double *at = r + b * stride;
        const int low = _mm256_movemask_pd(_mm256_cmp_pd(_mm256_loadu_pd(at), limit, _CMP_LT_OQ)),
                  high = _mm256_movemask_pd(_mm256_cmp_pd(_mm256_loadu_pd(at + 4), limit, _CMP_LT_OQ));
        marks[b] = (uint8_t)(low | high << 4);
    }
}

FOR_V3 static size_t marked_3(const uint32_t *list, size_t n, const uint8_t *bits, uint32_t *out)
{
    size_t count = 0;
    for (size_t k = 0; k < n; k += 8) {
        const __m256i j = _mm256_loadu_si256((const __m256i *)(list + k));
        _mm256_storeu_si256((__m256i *)(out + count), picked_3(j, bits[k / 8]));
        count += (size_t)__builtin_popcount(bits[k / 8]);
    }
    return count;
}

/* A difference to the nearest image, and for which it is not the point itself. */
FOR_V3 INLINE __m256d nearest_four(__m256d difference, double period, double frequency, unsigned *image)
{
    const __m256d k = _mm256_round_pd(_mm256_mul_pd(difference, _mm256_set1_pd(frequency)),
                                      _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
    *image |= (unsigned)_mm256_movemask_pd(_mm256_cmp_pd(k, _mm256_setzero_pd(), _CMP_NEQ_UQ));
    return _mm256_sub_pd(difference, _mm256_mul_pd(_mm256_set1_pd(period), k));
}

/* What the search around one point compares with. */
typedef struct Around3 {
    __m256d x[3], limit;
} Around3;

/* Which of up to four points are near, as bits. */
FOR_V3 INLINE unsigned near_four(const Points *points, uint32_t j, uint32_t last, const Around3 *around, bool *images,
                                 int dim, bool periodic)
{
    if (j >= last) return 0;
    const long long left = last - j;
    const __m256i some = _mm256_cmpgt_epi64(_mm256_set1_epi64x(left), _mm256_setr_epi64x(0, 1, 2, 3));
    unsigned image = 0;
    __m256d r2 = _mm256_setzero_pd();
    for (int d = 0; d < dim; d++) {
        __m256d dx = _mm256_sub_pd(around->x[d], _mm256_maskload_pd(points->x[d] + j, some));
        if (periodic) dx = nearest_four(dx, points->period[d], points->frequency[d], &image);
        r2 = _mm256_add_pd(r2, _mm256_mul_pd(dx, dx));
    }
    const __m256d near = _mm256_and_pd(_mm256_cmp_pd(r2, around->limit, _CMP_LT_OQ), _mm256_castsi256_pd(some));
    const unsigned bits = (unsigned)_mm256_movemask_pd(near);
    *images |= (bits & image) != 0;
    return bits;
}

FOR_V3 INLINE size_t near_3(const Points *points, uint32_t first, uint32_t last, const double at[3], double distance2,
                            uint32_t self, uint32_t *out, bool *images, int dim, bool periodic)
{
    const Around3 around = {{_mm256_set1_pd(at[0]), _mm256_set1_pd(at[1]), _mm256_set1_pd(at[2])},
                            _mm256_set1_pd(distance2)};
    const __m256i step = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    size_t count = 0;
    for (uint32_t j = first; j < last; j += 8) {
        unsigned bits = near_four(points, j, last, &around, images, dim, periodic) |
                        near_four(points, j + 4, last, &around, images, dim, periodic) << 4;
        if (self - j < 8) bits &= ~(1u << (self - j));
        const __m256i index = _mm256_add_epi32(_mm256_set1_epi32((int)j), step);
        _mm256_storeu_si256((__m256i *)(out + count), picked_3(index, bits));
        count += (size_t)__builtin_popcount(bits);
    }
    return count;
}

NEAR_FUNCTIONS(near_3, FOR_V3)

FOR_V4 static void marks_4(const double *r, size_t stride, size_t blocks, double reach, uint8_t *marks)
{
    const __m512d limit = _mm512_set1_pd(reach);
    for (size_t b = 0; b < blocks; b++)
        marks[b] = _mm512_cmp_pd_mask(_mm512_loadu_pd(r + b * stride), limit, _CMP_LT_OQ);
}

FOR_V4 static size_t marked_4(const uint32_t *list, size_t n, const uint8_t *bits, uint32_t *out)
{
    size_t count = 0;
    for (size_t k = 0; k < n; k += 8) {
        const __m256i j = _mm256_loadu_si256((const __m256i *)(list + k));
        _mm256_storeu_si256((__m256i *)(out + count), _mm256_maskz_compress_epi32(bits[k / 8], j));
        count += (size_t)__builtin_popcount(bits[k / 8]);
    }
    return count;
}

FOR_V4 INLINE __m512d nearest_eight(__m512d difference, double period, double frequency, __mmask8 *image)
{
    const __m512d k = _mm512_roundscale_pd(_mm512_mul_pd(difference, _mm512_set1_pd(frequency)),
                                           _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
    *image |= _mm512_cmp_pd_mask(k, _mm512_setzero_pd(), _CMP_NEQ_UQ);
    return _mm512_sub_pd(difference, _mm512_mul_pd(_mm512_set1_pd(period), k));
}

FOR_V4 INLINE size_t near_4(const Points *points, uint32_t first, uint32_t last, const double at[3], double distance2,
                            uint32_t self, uint32_t *out, bool *images, int dim, bool periodic)
{
    const __m512d around[] = {_mm512_set1_pd(at[0]), _mm512_set1_pd(at[1]), _mm512_set1_pd(at[2])},
                  limit = _mm512_set1_pd(distance2);
    const __m256i me = _mm256_set1_epi32((int)self), step = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    size_t count = 0;
    for (uint32_t j = first; j < last; j += 8) {
        const __mmask8 some = last - j < 8 ? (__mmask8)((1u << (last - j)) - 1) : 0xff;
        __mmask8 image = 0;
        __m512d r2 = _mm512_setzero_pd();
        for (int d = 0; d < dim; d++) {
            __m512d dx = _mm512_sub_pd(around[d], _mm512_maskz_loadu_pd(some, points->x[d] + j));
            if (periodic) dx = nearest_eight(dx, points->period[d], points->frequency[d], &image);
            r2 = _mm512_add_pd(r2, _mm512_mul_pd(dx, dx));
        }
        const __m256i index = _mm256_add_epi32(_mm256_set1_epi32((int)j), step);
        const __mmask8 near =
            _mm512_mask_cmp_pd_mask(some, r2, limit, _CMP_LT_OQ) & _mm256_cmpneq_epi32_mask(index, me);
        _mm256_storeu_si256((__m256i *)(out + count), _mm256_maskz_compress_epi32(near, index));
        count += (size_t)__builtin_popcount(near);
        *images |= (near & image) != 0;
    }
    return count;
}

NEAR_FUNCTIONS(near_4, FOR_V4)

#endif

void select_marks(Level level, const double *r, size_t stride, size_t blocks, double reach, uint8_t *marks)
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
