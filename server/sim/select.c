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
#endif
    plain_marks(r, stride, blocks, reach, marks);
}

size_t select_marked(Level level, const uint32_t *list, size_t n, const uint8_t *bits, uint32_t *out)
{
    (void)level;
#if HAS_LEVELS
    if (level == LEVEL_V4) return marked_4(list, n, bits, out);
#endif
    return plain_marked(list, n, bits, out);
}

size_t select_near(Level level, const Points *points, uint32_t first, uint32_t last, const double at[3],
                   double distance2, uint32_t self, uint32_t *out)
{
    (void)level;
#if HAS_LEVELS
    if (level == LEVEL_V4) return near_4(points, first, last, at, distance2, self, out);
#endif
    return plain_near(points, first, last, at, distance2, self, out);
}
