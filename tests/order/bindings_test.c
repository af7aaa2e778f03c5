/* SPDX-License-Identifier: Apache-2.0 */
/* Sparse bindings, which only semaphores, fences and idle queues put in order. */
#include "program.h"

SCRIPT_TEST(a_queue_puts_bindings_in_no_order,
            "10; bind 11; bind 12; 13; ran 10 11 12 13;"
            "11 unchecked; 11 not after 10; 12 not after 10 11; 13 not after 11 12; 13 after 10;")

SCRIPT_TEST(semaphores_put_bindings_in_order,
            "binary S T; timeline U;"
            "10 signals S; bind 11 waits S signals T; 20; 21 waits T signals U=1;"
            "bind 30 waits U=1;"
            "11 after 10; 21 after 11; 30 after 11; 20 not after 11;")

/* To follow a binding is to follow all before it, or it is not known to be followed. */
SCRIPT_TEST(a_signal_is_of_its_own_binding,
            "binary S T; bind 10 signals S; bind 11; bind 12 signals T; 20 waits S; 30 waits T;"
            "20 after 10; 20 not after 11; 30 not after 11;")

SCRIPT_TEST(a_chain_of_bindings_is_followed,
            "timeline S; bind 10 signals S=1; bind 11 waits S=1 signals S=2;"
            "bind 12 waits S=2 signals S=3; 13 waits S=3;"
            "11 after 10; 12 after 11; 13 after 10 11 12;")

SCRIPT_TEST(a_fence_covers_all_bindings_of_its_call,
            "fence F; bind 10 then 11 fence F; bind 12; 13; sees F; 20;"
            "13 not after 10; 20 after 10 11; 20 not after 12;")

SCRIPT_TEST(an_idle_queue_has_bound_all,
            "bind 10; bind 11; bind 20; idle 1; 30; 30 after 10 11; 30 not after 20;"
            "idle; 31; 31 after 20;")

/* What the host sees later counts for what a semaphore signals later. */
SCRIPT_TEST(bindings_after_an_idle_wait_are_followed_again,
            "binary S; bind 10; idle 1; bind 11 signals S; 20 waits S; 20 after 10 11;")

SCRIPT_TEST(bindings_that_fail_never_execute,
            "binary S; bind 10 fails; bind 11 signals S; 12 waits S; ran 11 12; 12 after 11;")

/* Bindings don't wait for commands before them, nor do commands for bindings before them. */
SCRIPT_TEST(sparse_bindings_pass_order_on,
            "fence F; binary S T; 20; 10 signals S; bind 0 on 2 waits S signals T fence F; 21;"
            "30 waits T; 30 after 10; 30 not after 20; 21 not after 10;"
            "sees F; 40; 40 after 10; 40 not after 20;")

SCRIPT_TEST(bindings_are_held_back_too,
            "timeline S; binary T; bind 0 on 2 waits S=1 signals T;"
            "30 waits T; 10 signals S=1; 30 after 10;")

SCRIPT_TEST(bindings_pass_commands_that_wait_for_them,
            "timeline S; 10 waits S=1; 11; bind 12 signals S=1; ran 12 10 11;"
            "10 after 12; 11 after 12; idle; 20; losses 0; 20 after 11;")

SCRIPT_TEST(commands_and_bindings_pass_bindings,
            "timeline S; bind 10 waits S=2; bind 11 waits S=1; 12 signals S=1; ran 12 11;"
            "bind 13 signals S=2; ran 12 11 13 10; 11 after 12;")

/* Signals of one queue come in the order of submission. */
SCRIPT_TEST(signals_pass_no_signals,
            "timeline S T U; 10 waits S=1 signals T=1; bind 11 signals U=1; 20 waits U=1; ran;"
            "30 signals S=1; ran 30 10 11 20; 20 after 10 11;")
