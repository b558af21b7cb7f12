"""This program beside independent code: models, optimisers, samplers, colours, error reports. See scripts/cross_check."""
