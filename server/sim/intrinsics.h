/* SPDX-License-Identifier: BSD-3-Clause */
/* All intrinsics of instruction sets, and their twins for any machine, which give the same bits: what compilers do not make of
 * plain loops. Marks and picks are offered by select.h, fetches are part of pairs.h. */
#ifndef SIM_INTRINSICS_H
#define SIM_INTRINSICS_H

#include "sim/select.h"
#if HAS_LEVELS
#include <immintrin.h>
#endif

/* --- any machine ------------------------------------------------------------------------------------------------------- */

static inline void plain_marks(const double *r, size_t stride, size_t blocks, double reach, uint8_t *marks)
{
    for (size_t b = 0; b < blocks; b++) {
        unsigned bits = 0;
        for (unsigned l = 0; l < 8; l++) bits |= (unsigned)(r[b * stride + l] < reach) << l;
        marks[b] = (uint8_t)bits;
    }
}

static inline size_t plain_marked(const uint32_t *list, size_t n, const uint8_t *bits, uint32_t *out)
{
    size_t count = 0;
    for (size_t k = 0; k < n; k++) {
        out[count] = list[k];
        count += (unsigned)bits[k / 8] >> k % 8 & 1u;
    }
    return count;
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

typedef double Quad __attribute__((vector_size(32), may_alias));

/* Four bundles, transposed. */
typedef struct Quads {
    Quad a, b, c, d;
} Quads;

INLINE Quads transposed(double (*restrict bundle)[4], const uint32_t *restrict j)
{
    const Quad k0 = *(const Quad *)bundle[j[0]], k1 = *(const Quad *)bundle[j[1]], k2 = *(const Quad *)bundle[j[2]],
               k3 = *(const Quad *)bundle[j[3]];
    const Quad even01 = __builtin_shufflevector(k0, k1, 0, 4, 2, 6),
               odd01 = __builtin_shufflevector(k0, k1, 1, 5, 3, 7);
    const Quad even23 = __builtin_shufflevector(k2, k3, 0, 4, 2, 6),
               odd23 = __builtin_shufflevector(k2, k3, 1, 5, 3, 7);
    return (Quads){
        __builtin_shufflevector(even01, even23, 0, 1, 4, 5), __builtin_shufflevector(odd01, odd23, 0, 1, 4, 5),
        __builtin_shufflevector(even01, even23, 2, 3, 6, 7), __builtin_shufflevector(odd01, odd23, 2, 3, 6, 7)};
}

/* Bundles of eight particles, transposed: a gets the first quantity of all, b the second ... */
INLINE void fetch_quads(double (*restrict bundle)[4], const uint32_t *restrict j, double *restrict a,
                        double *restrict b, double *restrict c, double *restrict d)
{
    for (int l = 0; l < LANES; l += 4) {
        const Quads quads = transposed(bundle, j + l);
        *(Quad *)(a + l) = quads.a;
        *(Quad *)(b + l) = quads.b;
        if (c) *(Quad *)(c + l) = quads.c;
        if (d) *(Quad *)(d + l) = quads.d;
    }
}

#if HAS_LEVELS
/* --- AVX2 -------------------------------------------------------------------------------------------------------------- */

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

FOR_V3 static inline void marks_3(const double *r, size_t stride, size_t blocks, double reach, uint8_t *marks)
{
    const __m256d limit = _mm256_set1_pd(reach);
    for (size_t b = 0; b < blocks; b++) {
        const double *at = r + b * stride;
        const int low = _mm256_movemask_pd(_mm256_cmp_pd(_mm256_loadu_pd(at), limit, _CMP_LT_OQ)),
                  high = _mm256_movemask_pd(_mm256_cmp_pd(_mm256_loadu_pd(at + 4), limit, _CMP_LT_OQ));
        marks[b] = (uint8_t)(low | high << 4);
    }
}

FOR_V3 static inline size_t marked_3(const uint32_t *list, size_t n, const uint8_t *bits, uint32_t *out)
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

/* Halves k of two bundles. gcc makes one instruction of it only if it is told so. */
#define HALVES(k, first, second)                                                                                       \
    _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_load_pd(bundle[first] + (k))), _mm_load_pd(bundle[second] + (k)), 1)

/* The same bits, put together as they are loaded: to exchange halves of registers afterwards is what machines with AVX2 are slow at. */
FOR_V3 INLINE void fetch_halves(double (*restrict bundle)[4], const uint32_t *restrict j, double *restrict a,
                                double *restrict b, double *restrict c, double *restrict d)
{
    for (int l = 0; l < LANES; l += 4) {
        const Quad first02 = HALVES(0, j[l], j[l + 2]), first13 = HALVES(0, j[l + 1], j[l + 3]),
                   last02 = HALVES(2, j[l], j[l + 2]), last13 = HALVES(2, j[l + 1], j[l + 3]);
        *(Quad *)(a + l) = __builtin_shufflevector(first02, first13, 0, 4, 2, 6);
        *(Quad *)(b + l) = __builtin_shufflevector(first02, first13, 1, 5, 3, 7);
        if (c) *(Quad *)(c + l) = __builtin_shufflevector(last02, last13, 0, 4, 2, 6);
        if (d) *(Quad *)(d + l) = __builtin_shufflevector(last02, last13, 1, 5, 3, 7);
    }
}

/* --- AVX-512 ----------------------------------------------------------------------------------------------------------- */

FOR_V4 static inline void marks_4(const double *r, size_t stride, size_t blocks, double reach, uint8_t *marks)
{
    const __m512d limit = _mm512_set1_pd(reach);
    for (size_t b = 0; b < blocks; b++)
        marks[b] = _mm512_cmp_pd_mask(_mm512_loadu_pd(r + b * stride), limit, _CMP_LT_OQ);
}

FOR_V4 static inline size_t marked_4(const uint32_t *list, size_t n, const uint8_t *bits, uint32_t *out)
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

typedef double Oct __attribute__((vector_size(64), may_alias));

/* One load and one that is put beside it: the exchange of halves that gcc makes of a shuffle has but one unit, which all that follows
 * waits for. A macro, as no function may return a vector that its instruction set does not have. */
#define BOTH(first, second)                                                                                            \
    _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_load_pd(bundle[first])), _mm256_load_pd(bundle[second]), 1)

/* The same where registers hold eight doubles, with a third of the shuffles. What is stored is loaded again as eight, which could
 * not be forwarded from two stores of four. */
FOR_V4 INLINE void fetch_octs(double (*restrict bundle)[4], const uint32_t *restrict j, double *restrict a,
                              double *restrict b, double *restrict c, double *restrict d)
{
    const Oct k04 = BOTH(j[0], j[4]), k15 = BOTH(j[1], j[5]), k26 = BOTH(j[2], j[6]), k37 = BOTH(j[3], j[7]);
    const Oct even01 = __builtin_shufflevector(k04, k15, 0, 8, 2, 10, 4, 12, 6, 14),
              odd01 = __builtin_shufflevector(k04, k15, 1, 9, 3, 11, 5, 13, 7, 15),
              even23 = __builtin_shufflevector(k26, k37, 0, 8, 2, 10, 4, 12, 6, 14),
              odd23 = __builtin_shufflevector(k26, k37, 1, 9, 3, 11, 5, 13, 7, 15);
    *(Oct *)a = __builtin_shufflevector(even01, even23, 0, 1, 8, 9, 4, 5, 12, 13);
    *(Oct *)b = __builtin_shufflevector(odd01, odd23, 0, 1, 8, 9, 4, 5, 12, 13);
    if (c) *(Oct *)c = __builtin_shufflevector(even01, even23, 2, 3, 10, 11, 6, 7, 14, 15);
    if (d) *(Oct *)d = __builtin_shufflevector(odd01, odd23, 2, 3, 10, 11, 6, 7, 14, 15);
}

#endif

#endif
