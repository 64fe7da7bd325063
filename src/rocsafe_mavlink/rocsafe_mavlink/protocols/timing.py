# SPDX-License-Identifier: Apache-2.0
"""Deadlines and repetitions of the protocols, as values with their reasons."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandTiming:
    """Timing of one command.

    Attributes
    ----------
    repeat_s
        A command without an answer is repeated after this time, seconds.
    largest_send_count
        A command is sent at most so often.
    text_before_s, text_after_s
        Texts of the autopilot in this time around a refusal explain it, seconds; measured on
        ArduCopter 4.7.
    progress_s
        An answer that a command is in progress extends the wait by this time, seconds.
    longest_s
        A command is given up after this time whatever is answered, seconds.
    """

    repeat_s: float = 1.5
    largest_send_count: int = 4
    text_before_s: float = 0.5
    text_after_s: float = 1.5
    progress_s: float = 10.0
    longest_s: float = 30.0


@dataclass(frozen=True, slots=True, kw_only=True)
class TransferTiming:
    """Timing of the transfer of a mission, a fence or rally points.

    Attributes
    ----------
    offer_again_s
        An offer without a request is repeated after this time, seconds.
    largest_offer_count
        Offers at most. With 40 % of all messages lost, one vehicle in a thousand leaves so many
        unanswered.
    fewest_stuck_offers
        Offers after which a refusal by another type means that the autopilot is stuck, see
        `release_s`.
    release_s
        A PX4 forgets that it is in a transfer only when a transfer of it times out, after 5 s. So
        one that refuses every offer is asked for a list, which is then left to time out, seconds.
    no_request_s
        Autopilots repeat a request sooner than this, seconds.
    doubled_s
        A request for the same item so soon is the same one twice, seconds: a PX4 asks again after
        0.25 s, an ArduPilot after 0.8 s.
    no_ack_s
        Silence for so long after the last item most likely means a lost acknowledgement, seconds.
    ask_again_s
        A question for an item to read is repeated after this time, seconds.
    largest_ask_count
        Questions for one item at most. With 40 % of all messages lost, one item in ten thousand
        goes unanswered so often.
    largest_try_count
        Uploads at most until one is read back as it was sent.
    longest_s, longest_item_s
        A transfer is given up after this time and so much for each item, seconds: a radio of
        57600 baud that loses a message in five carries an item both ways in half of it.
    clear_again_s, largest_clear_count
        A request to clear is repeated after this time, seconds, and at most so often.
    """

    offer_again_s: float = 1.5
    largest_offer_count: int = 15
    fewest_stuck_offers: int = 2
    release_s: float = 6.5
    no_request_s: float = 10.0
    doubled_s: float = 0.1
    no_ack_s: float = 3.5
    ask_again_s: float = 1.0
    largest_ask_count: int = 20
    largest_try_count: int = 5
    longest_s: float = 180.0
    longest_item_s: float = 2.0
    clear_again_s: float = 1.5
    largest_clear_count: int = 5


COMMAND_TIMING, TRANSFER_TIMING = CommandTiming(), TransferTiming()
