/* SPDX-License-Identifier: BSD-3-Clause */
/* A request and its reply. Replies are built of memory from malloc, as if they had been unpacked, and freed the same way. */
#include "net/exchange.h"

#include "common/wire/frame.h"
#include "net/handlers.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

uint64_t exchange_command(const Meniscus__Request *request)
{
    Meniscus__Request what = *request;
    what.has_id = what.has_deadline_ms = what.has_no_wait = false;
    const size_t size = meniscus__request__get_packed_size(&what);
    uint8_t *packed = malloc(size + 1);
    if (!packed) return 0;
    meniscus__request__pack(&what, packed);
    const uint64_t hash = XXH64(packed, size, 0);
    free(packed);
    return hash ? hash : 1;
}

Exchange *exchange_new(Meniscus__Request *request, const Who *who)
{
    Exchange *exchange = calloc(1, sizeof *exchange);
    Meniscus__Reply *reply = malloc(sizeof *reply);
    if (!exchange || !reply) {
        free(exchange);
        free(reply);
        request_free(request);
        return NULL;
    }
    meniscus__reply__init(reply);
    exchange->order.who = *who;
    exchange->order.deadline = INFINITY;
    exchange->request = request;
    exchange->command = exchange_command(request);
    exchange->reply = reply;
    if (request->has_id && request->id.len == ORDER_ID) memcpy(exchange->order.id, request->id.data, ORDER_ID);
    return exchange;
}

void exchange_free(Exchange *exchange)
{
    if (!exchange) return;
    for (size_t k = 0; k < EXCHANGE_ARRAYS; k++) free(exchange->arrays[k]);
    document_leave(exchange->order.document);
    request_free(exchange->request);
    meniscus__reply__free_unpacked(exchange->reply, NULL);
    free(exchange);
}

static Meniscus__Array *describe(const char *name, const char *type, const char *unit, const uint64_t *shape,
                                 size_t n_shape)
{
    Meniscus__Array *array = malloc(sizeof *array);
    if (!array) return NULL;
    meniscus__array__init(array);
    array->name = strdup(name);
    array->type = strdup(type);
    array->unit = strdup(unit);
    array->shape = malloc(n_shape * sizeof *shape);
    if (array->shape) memcpy(array->shape, shape, n_shape * sizeof *shape);
    array->n_shape = array->shape ? n_shape : 0;
    return array;
}

MnsStatus exchange_add(Exchange *exchange, const char *name, const char *type, const char *unit, const uint64_t *shape,
                       size_t n_shape, void *data, size_t size, MnsError *error)
{
    Meniscus__Reply *reply = exchange->reply;
    const size_t n = reply->n_arrays;
    if (!reply->arrays) reply->arrays = calloc(EXCHANGE_ARRAYS, sizeof(Meniscus__Array *));
    Meniscus__Array *array = n < EXCHANGE_ARRAYS && reply->arrays ? describe(name, type, unit, shape, n_shape) : NULL;
    if (!array) {
        free(data);
        return mns_fail(error, MNS_E_MEMORY, "no memory for the array %s", name);
    }
    array->has_xxh64 = true;
    array->xxh64 = XXH64(data, size, 0);
    reply->arrays[n] = array;
    exchange->arrays[n] = data;
    exchange->sizes[n] = size;
    reply->n_arrays++;
    return MNS_OK;
}

/* No half of a result goes with a failure. */
static void drop_result(Exchange *exchange)
{
    for (size_t k = 0; k < EXCHANGE_ARRAYS; k++) {
        free(exchange->arrays[k]);
        exchange->arrays[k] = NULL;
    }
    meniscus__reply__free_unpacked(exchange->reply, NULL);
    exchange->reply = malloc(sizeof *exchange->reply);
    if (exchange->reply) meniscus__reply__init(exchange->reply);
}

static void seal_failure(const Exchange *exchange)
{
    Meniscus__Reply *reply = exchange->reply;
    const MnsError *why = &exchange->order.error;
    free(reply->message);
    reply->message = strdup(why->text);
    if (why->path[0]) reply->path = strdup(why->path);
    reply->reason = strdup(mns_status_name(exchange->order.status));
    reply->allowed = calloc(RUN_STATES, sizeof *reply->allowed);
    for (unsigned state = 0; reply->allowed && state < RUN_STATES; state++)
        if (exchange->allowed & 1u << state) reply->allowed[reply->n_allowed++] = (Meniscus__State)state;
}

void exchange_seal(Exchange *exchange)
{
    Order *order = &exchange->order;
    if (!order->status && exchange->handler && exchange->handler->complete)
        order->status = exchange->handler->complete(exchange, &order->error);
    if (order->status) drop_result(exchange);
    exchange->sealed = true;
    Meniscus__Reply *reply = exchange->reply;
    if (!reply) return;
    if (order->status) seal_failure(exchange);
    reply->id.data = malloc(ORDER_ID);
    reply->has_id = reply->id.data != NULL;
    if (reply->has_id) memcpy(reply->id.data, order->id, reply->id.len = ORDER_ID);
    reply->has_code = reply->has_daemon_epoch = reply->has_state = reply->has_step = reply->has_time = true;
    reply->code = code_of(order->status);
    reply->daemon_epoch = exchange->epoch;
    reply->state = (Meniscus__State)order->state;
    reply->step = order->step;
    reply->time = order->t;
    reply->has_case_version = order->version > 0;
    reply->case_version = order->version;
    reply->has_effect_step = !order->status && exchange->at_step;
    reply->effect_step = order_effect(order);
}

Meniscus__Value *exchange_value(const char *name, double number, const char *text, const char *unit)
{
    Meniscus__Value *value = malloc(sizeof *value);
    if (!value) return NULL;
    meniscus__value__init(value);
    value->name = strdup(name);
    value->unit = strdup(unit ? unit : "");
    value->has_number = !isnan(number);
    value->number = number;
    if (text) value->text = strdup(text);
    return value;
}

MnsStatus exchange_values(Exchange *exchange, Meniscus__Value **values, size_t n, MnsError *error)
{
    Meniscus__Values *result = malloc(sizeof *result);
    bool whole = result != NULL;
    for (size_t k = 0; k < n; k++) whole = whole && values[k];
    if (!whole) {
        for (size_t k = 0; k < n; k++)
            if (values[k]) meniscus__value__free_unpacked(values[k], NULL);
        free(values);
        free(result);
        return mns_fail(error, MNS_E_MEMORY, "no memory for %zu values", n);
    }
    meniscus__values__init(result);
    result->n_values = n;
    result->values = values;
    exchange->reply->result_case = MENISCUS__REPLY__RESULT_VALUES;
    exchange->reply->values = result;
    return MNS_OK;
}
