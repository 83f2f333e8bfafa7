"""The pilot: what runs on board at each tick, from echo to propeller speed, for any plant."""
