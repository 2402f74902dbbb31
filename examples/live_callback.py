"""Print each estimate that stands at the second contact: python examples/live_callback.py."""

import firstcontact as fc


def main() -> None:
    """Follow five pinches of the simulated hand with the model of the package."""
    with fc.open("twin") as source:
        for event in fc.live(source, pinches=5):
            if isinstance(event, fc.Settled) and event.answer is not None:
                print(f"{event.answer.value:.0f} Shore A, {1e3 * event.answer.duration:.0f} ms")


if __name__ == "__main__":
    main()
