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
        count += bits[k / 8] >> k % 8 & 1u;
    }
    return count;
}

static size_t plain_near(const Points *points, uint32_t first, uint32_t last, const double at[3], double distance2,
                         uint32_t self, uint32_t *out)
{
    const double *x = points->x, *y = points->y, *z = points->z;
    size_t count = 0;
    for (uint32_t j = first; j < last; j++) {
        const double dx = at[0] - x[j], dy = at[1] - y[j], dz = z ? at[2] - z[j] : 0;
        out[count] = j;
        count += (size_t)((dx * dx + dy * dy + dz * dz < distance2) & (j != self));
    }
    return count;
}

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

/* Which of four points are near, as bits. */
FOR_V3 static inline unsigned near_four(const Points *points, size_t j, __m256d x, __m256d y, __m256d z, __m256d limit)
{
    const __m256d dx = _mm256_sub_pd(x, _mm256_loadu_pd(points->x + j)),
                  dy = _mm256_sub_pd(y, _mm256_loadu_pd(points->y + j));
    __m256d r2 = _mm256_add_pd(_mm256_mul_pd(dx, dx), _mm256_mul_pd(dy, dy));
    if (points->z) {
        const __m256d dz = _mm256_sub_pd(z, _mm256_loadu_pd(points->z + j));
        r2 = _mm256_add_pd(r2, _mm256_mul_pd(dz, dz));
    }
    return (unsigned)_mm256_movemask_pd(_mm256_cmp_pd(r2, limit, _CMP_LT_OQ));
}

FOR_V3 static size_t near_3(const Points *points, uint32_t first, uint32_t last, const double at[3], double distance2,
                            uint32_t self, uint32_t *out)
{
    const __m256d x = _mm256_set1_pd(at[0]), y = _mm256_set1_pd(at[1]), z = _mm256_set1_pd(at[2]),
                  limit = _mm256_set1_pd(distance2);
    const __m256i step = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    size_t count = 0;
    uint32_t j = first;
    for (; last - j >= 8; j += 8) {
        unsigned bits = near_four(points, j, x, y, z, limit) | near_four(points, j + 4, x, y, z, limit) << 4;
        if (self - j < 8) bits &= ~(1u << (self - j));
        const __m256i index = _mm256_add_epi32(_mm256_set1_epi32((int)j), step);
        _mm256_storeu_si256((__m256i *)(out + count), picked_3(index, bits));
        count += (size_t)__builtin_popcount(bits);
    }
    return count + plain_near(points, j, last, at, distance2, self, out + count);
}

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

FOR_V4 static size_t near_4(const Points *points, uint32_t first, uint32_t last, const double at[3], double distance2,
                            uint32_t self, uint32_t *out)
{
    const double *x = points->x, *y = points->y, *z = points->z;
    const __m512d xi = _mm512_set1_pd(at[0]), yi = _mm512_set1_pd(at[1]), zi = _mm512_set1_pd(at[2]),
                  limit = _mm512_set1_pd(distance2);
    const __m256i me = _mm256_set1_epi32((int)self), step = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    size_t count = 0;
    for (uint32_t j = first; j < last; j += 8) {
        const __mmask8 some = last - j < 8 ? (__mmask8)((1u << (last - j)) - 1) : 0xff;
        const __m512d dx = _mm512_sub_pd(xi, _mm512_maskz_loadu_pd(some, x + j)),
                      dy = _mm512_sub_pd(yi, _mm512_maskz_loadu_pd(some, y + j));
        __m512d r2 = _mm512_add_pd(_mm512_mul_pd(dx, dx), _mm512_mul_pd(dy, dy));
        if (z) {
            const __m512d dz = _mm512_sub_pd(zi, _mm512_maskz_loadu_pd(some, z + j));
            r2 = _mm512_add_pd(r2, _mm512_mul_pd(dz, dz));
        }
        const __m256i index = _mm256_add_epi32(_mm256_set1_epi32((int)j), step);
        const __mmask8 near =
            _mm512_mask_cmp_pd_mask(some, r2, limit, _CMP_LT_OQ) & _mm256_cmpneq_epi32_mask(index, me);
        _mm256_storeu_si256((__m256i *)(out + count), _mm256_maskz_compress_epi32(near, index));
        count += (size_t)__builtin_popcount(near);
    }
    return count;
}

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

size_t select_near(Level level, const Points *points, uint32_t first, uint32_t last, const double at[3],
                   double distance2, uint32_t self, uint32_t *out)
{
    (void)level;
#if HAS_LEVELS
    if (level == LEVEL_V4) return near_4(points, first, last, at, distance2, self, out);
    if (level == LEVEL_V3) return near_3(points, first, last, at, distance2, self, out);
#endif
    return plain_near(points, first, last, at, distance2, self, out);
}
